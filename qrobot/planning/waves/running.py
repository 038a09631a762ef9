"""Waves planned one after the other: time shared out, a stock that shrinks, what is done kept."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from qrobot._files import StrPath
from qrobot.backends import Stop, capabilities
from qrobot.errors import InfeasibleError, InputError
from qrobot.plan.objective import objective_named
from qrobot.planning.run import Progress
from qrobot.planning.solving import solve
from qrobot.planning.strategy import check_arguments
from qrobot.planning.waves.bounding import pool_bound
from qrobot.planning.waves.cutting import cut
from qrobot.planning.waves.folder import Folder, fingerprint
from qrobot.planning.waves.outcome import Comparison, Wave, Waves
from qrobot.problem import MAX_STOPS, Instance, Item, Order, Place, Stock
from qrobot.problem.formats import read

__all__ = ["plan_waves"]

SUMMED = ("distance", "time", "trips")
"""Objectives of which the plans of several waves cost the sum."""

LEAST = 0.1
"""Seconds that a wave gets however late it is, so that it has a plan."""

Listener = Callable[[Progress], None]


def plan_waves(
    pool: Instance | StrPath,
    *,
    by: str = "size",
    size: int = MAX_STOPS,
    zones: str = "blocks",
    deadline: float | None = None,
    max_work: int | None = None,
    backend: str = "auto",
    seed: int = 0,
    objective: str = "distance",
    routing: str = "exact",
    folder: StrPath | None = None,
    resume: bool = False,
    compare: bool = False,
    pairs: bool = False,
    stop: Stop | None = None,
    on_progress: Listener | None = None,
    on_wave: Callable[[Wave], None] | None = None,
    **options: Any,
) -> Waves:
    """Cut a pool of orders into waves and plan each.

    The robots make one wave after the other: each wave begins when the last robot is back, and
    every robot may make as many trips in each as the pool says. In a wave's own question, times of
    orders count from its beginning.

    Parameters
    ----------
    pool
        Orders of any number, or the path of their file.
    by, size, zones
        How the waves are cut; see `cut`.
    deadline
        Wall-clock seconds for all waves, shared by their stops; without it and without
        `max_work`, 10 seconds a wave.
    max_work
        Limit of work units of each wave.
    backend, seed, objective, routing, **options
        As of `solve`; a local backend, and an objective that is a sum: ``distance``,
        ``time`` or ``trips``.
    folder
        Where the question and the plan of each wave are written as soon as it is planned, and
        ``waves.json`` with the summary.
    resume
        Keep the finished waves of the folder, and plan the others.
    compare
        Also plan the whole pool at once, where it is small enough, with as much time and as many
        trips as all waves had.
    pairs
        Also plan neighbouring waves together, two by two, where both are small enough.
    stop
        A stop that the caller can `request`; the waves that are planned stay.
    on_progress
        Called with `Progress` at every step and better plan.
    on_wave
        Called with each wave that has a plan.

    Raises
    ------
    InfeasibleError
        When a wave has no plan.
    InputError
        When an argument, the pool or the folder cannot be used.
    BackendError
        When the backend failed.
    """
    check_arguments(backend=backend, deadline=deadline, max_work=max_work, seed=seed)
    question = pool if isinstance(pool, Instance) else read(pool, pool=True)
    if objective not in SUMMED:
        raise InputError(
            f"{objective!r} of several waves is no sum",
            field="objective",
            advice=f"use one of: {', '.join(SUMMED)}",
        )
    if backend != "auto" and not capabilities(backend).local:
        raise InputError(
            f"backend {backend} is remote", field="backend", advice="name a local one, as auto"
        )
    wishes = {
        "backend": backend,
        "max_work": max_work,
        "seed": seed,
        "objective": objective,
        "routing": routing,
        **options,
    }
    run = _Run(question, wishes, deadline, stop or Stop(), on_progress)
    run.tell("cutting")
    parts = cut(question, by=by, size=size, zones=zones)
    whole = _whole(question, len(parts)) if compare else None
    _refuse_pairs(question, pairs)
    asked = {"by": by, "size": size, "zones": zones if by == "zone" else None, **wishes}
    asked = {"pool": fingerprint(question) if folder is not None else None, **asked}
    store = None if folder is None else Folder(folder, asked, resume=resume)
    run.tell("bounding")
    bound = objective_named(objective).bound(question, pool_bound(question, run.limits))
    found = Waves(question, asked, (), len(parts), bound, notes=question.remarks)
    for orders in parts:
        wave = run.wave(orders, parts, store)
        if wave is None:
            break
        found = dataclasses.replace(found, waves=(*found.waves, wave))
        if on_wave is not None:
            on_wave(wave)
        if store is not None:
            store.summarise(found)
        if wave.ended == "interrupted":
            break
    if found.is_complete:
        compared = run.compared(found.waves, whole, pairs)
        found = dataclasses.replace(found, compared=compared, notes=tuple(run.notes))
    if store is not None:
        store.summarise(found)
    return found


class _Run:
    """One call of `plan_waves`: what is left of time and stock, and what is told."""

    def __init__(
        self,
        pool: Instance,
        wishes: dict[str, Any],
        deadline: float | None,
        stop: Stop,
        listener: Listener | None,
    ) -> None:
        self.pool, self.wishes, self.listener = pool, wishes, listener
        self.limits = Stop(deadline, parent=stop)
        # Not the deadline of all: a wave that comes too late gets a little time nevertheless.
        self.stop = stop
        self.shelves = _Shelves(pool)
        self.items = {item.id: item for item in pool.items}
        self.begins = 0.0
        self.done = 0
        self.notes = list(pool.remarks)

    def tell(self, step: str) -> None:
        """Tell the listener what is done now."""
        if self.listener is not None:
            self.listener(Progress(step, self.limits.elapsed, None, 0.0, self.wishes["objective"]))

    def _plan(self, title: str, question: Instance, seconds: float | None, work: int = 1) -> Any:
        """Return the result of a question; `work` times the limit of work."""
        listener, limit = self.listener, self.wishes["max_work"]
        wishes = {**self.wishes, "max_work": None if limit is None else work * limit}

        def tell(progress: Progress) -> None:
            if listener is not None:
                listener(dataclasses.replace(progress, step=f"{title}, {progress.step}"))

        return solve(question, deadline=seconds, stop=self.stop, on_progress=tell, **wishes)

    def wave(
        self, orders: Sequence[int], parts: Sequence[Sequence[int]], store: Folder | None
    ) -> Wave | None:
        """Plan the next wave; return it, or None when it was interrupted before it had a plan."""
        self.done += 1
        number, title = self.done, f"wave {self.done} of {len(parts)}"
        question = self.question(orders, number)
        wave = None if store is None else store.kept(number, question, self.begins)
        if wave is None:
            if self.limits.requested:
                return None
            try:
                result = self._plan(title, question, self._share(orders, parts[number - 1 :]))
            except InfeasibleError as error:
                if self.limits.requested and not error.proven:
                    return None
                raise InfeasibleError(f"{title}: {error.reason}", proven=error.proven) from None
            if store is not None:
                store.save(number, result, question)
            wave = Wave(
                number,
                question,
                result.plan,
                result.measures,
                self.begins,
                result.bound,
                result.is_optimal,
                result.ended,
                result.timing.total,
            )
        self.shelves.take(wave)
        self.begins = wave.ends
        return wave

    def _share(self, orders: Sequence[int], left: Sequence[Sequence[int]]) -> float | None:
        """Return the seconds of a wave: its share of what is left, by its items."""
        if self.limits.seconds is None:
            return None
        items = [sum(len(self.pool.orders[o].items) for o in part) for part in left]
        own = sum(len(self.pool.orders[o].items) for o in orders)
        return max(LEAST, self.limits.remaining * own / sum(items))

    def question(self, orders: Sequence[int], number: int) -> Instance:
        """Return the question of a wave."""
        chosen = [self.pool.orders[o] for o in orders]
        items = tuple(self.items[name] for order in chosen for name in order.items)
        return dataclasses.replace(
            self.pool,
            name=f"{self.pool.name}-wave-{number:03d}",
            orders=tuple(_after(order, self.begins) for order in chosen),
            robots=tuple(
                dataclasses.replace(r, available=max(0.0, r.available - self.begins))
                for r in self.pool.robots
            ),
            items=items,
            stock=self.shelves.stock(items),
            reference=None,
            remarks=(),
            pool=False,
        )

    def compared(
        self, waves: Sequence[Wave], whole: Instance | None, pairs: bool
    ) -> tuple[Comparison, ...]:
        """Return what neighbouring waves, and all of them, cost when they are planned together."""
        groups: list[tuple[Sequence[Wave], Instance]] = []
        if pairs:
            for first, second in zip(waves[::2], waves[1::2], strict=False):
                if first.stops + second.stops <= MAX_STOPS:
                    groups.append(((first, second), self._joined(first, second)))
                else:
                    self.notes.append(
                        f"waves {first.number} and {second.number} have more stops than one plan: "
                        "they are not planned together"
                    )
        if whole is not None:
            groups.append((waves, whole))
        found = []
        for group, question in groups:
            if self.limits.requested:
                break
            limited = self.limits.seconds is not None or self.wishes["max_work"] is None
            seconds = max(LEAST, sum(wave.seconds for wave in group)) if limited else None
            title = f"waves {group[0].number} to {group[-1].number} together"
            result = self._plan(title, question, seconds, len(group))
            apart = math.fsum(wave.plan.cost for wave in group)
            numbers = tuple(wave.number for wave in group)
            found.append(Comparison(numbers, apart, result.cost, result.bound))
        return tuple(found)

    def _joined(self, first: Wave, second: Wave) -> Instance:
        names = {order.id for wave in (first, second) for order in wave.instance.orders}
        chosen = [o for o, order in enumerate(self.pool.orders) if order.id in names]
        self.begins = first.begins
        return _with_trips(self.question(chosen, first.number), 2)


class _Shelves:
    """What of the stock is left for the next wave.

    In every place there stay the pieces that items of later waves have as their first choice.
    """

    def __init__(self, pool: Instance) -> None:
        self.known = {one.article for one in pool.stock}
        self.spare = Counter({(one.article, one.place): one.quantity for one in pool.stock})
        self.spare.subtract(self._choices(pool.items))

    def _choices(self, items: Sequence[Item]) -> Counter[tuple[str, Place]]:
        found: Counter[tuple[str, Place]] = Counter()
        for item in items:
            if item.article in self.known:
                found[item.article, item.place] += item.quantity
        return found

    def stock(self, items: Sequence[Item]) -> tuple[Stock, ...]:
        """Return the stock that the items of a wave may be taken from."""
        own = {item.article for item in items}
        there = self.spare + self._choices(items)
        return tuple(
            Stock(article, place, pieces)
            for (article, place), pieces in there.items()
            if article in own
        )

    def take(self, wave: Wave) -> None:
        """Take what a wave's plan takes."""
        self.spare.update(self._choices(wave.instance.items))
        for pick in wave.plan.picks:
            self.spare[pick.article, pick.place] -= pick.quantity


def _after(order: Order, begins: float) -> Order:
    """Return an order whose times count from the beginning of its wave."""
    if begins == 0.0:
        return order
    release = max(0.0, order.release - begins)
    if order.deadline < begins + release:
        raise InfeasibleError(
            f"the wave of order {order.id!r} begins at {begins:.0f} s, and the order must be back "
            f"at {order.deadline:.0f} s; cut by due, or use more robots"
        )
    return dataclasses.replace(
        order,
        release=release,
        due=max(release, order.due - begins),
        deadline=order.deadline - begins,
    )


def _with_trips(instance: Instance, times: int) -> Instance:
    """Return an instance whose robots may make so many times as many trips."""
    fleet = tuple(dataclasses.replace(r, trips=times * r.trips) for r in instance.robots)
    return dataclasses.replace(instance, robots=fleet)


def _whole(pool: Instance, waves: int) -> Instance:
    """Return the pool as one question, or refuse it."""
    try:
        return dataclasses.replace(_with_trips(pool, max(1, waves)), pool=False)
    except InputError as error:
        raise InputError(
            f"the pool cannot be planned at once: {error.problem}",
            field="compare",
            advice="compare pairs of waves (pairs), or leave it out",
        ) from None


def _refuse_pairs(pool: Instance, pairs: bool) -> None:
    if pairs and pool.stock:
        raise InputError(
            "waves share a stock, so two of them are not planned again",
            field="pairs",
            advice="leave it out",
        )
