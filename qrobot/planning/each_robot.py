"""Batches from a central plan, sequences from the robots: one robot, one trip (K = 1) at a time."""

from __future__ import annotations

import dataclasses
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from qrobot.backends import Stop
from qrobot.errors import BackendError, InfeasibleError, InputError, QRobotError
from qrobot.plan import Plan, check
from qrobot.plan.objective import DISTANCE, objective_named
from qrobot.planning.own_trips import EachRobot, OwnTrip
from qrobot.planning.result import Result
from qrobot.planning.run import TIE, Progress
from qrobot.planning.solving import solve, strategy_of
from qrobot.planning.strategy import DEFAULT_DEADLINE, check_arguments
from qrobot.problem import Instance, Order, Place, Robot
from qrobot.problem.times import Times

__all__ = ["route_each"]

LEAST = 0.1
"""Seconds that a trip gets however late it is."""


def route_each(
    central: Result,
    backend: str,
    *,
    deadline: float | None = None,
    max_work: int | None = None,
    seed: int = 0,
    control: bool = False,
    max_cost: float | None = None,
    stop: Stop | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    **options: Any,
) -> Result:
    """Let each robot plan the sequence of its own trips, whose orders a central plan chose.

    Each trip becomes a question of its own: one robot, one trip, a stop for each place, nothing to
    weigh. The backend, any sampler or planner, answers it as `solve` does: samplers by their reads
    with repair and polish after them, told apart in the result.

    Parameters
    ----------
    central
        The plan whose batches stay.
    backend
        Who plans each sequence.
    deadline
        Seconds for all trips together, shared; without it and `max_work`, 10.
    max_work
        Limit of work units of each trip.
    max_cost
        US dollars that all trips together may cost on a remote backend; each gets a like share.
    seed, control, stop, on_progress, **options
        As of `solve`.

    Returns
    -------
    Result
        The checked plan of the robots' own sequences, with `Result.each_robot` beside it. A trip
        that the backend cannot take keeps the central sequence, and the reason is told.

    Raises
    ------
    InputError
        When the plan is walked by a policy, or an option is not one of the backend.
    """
    check_arguments(backend=backend, deadline=deadline, max_work=max_work, seed=seed)
    instance = central.instance
    if instance.routing != "exact":
        raise InputError(
            f"the policy {instance.routing} tells the sequences of all trips",
            field="routing",
            advice="leave it out",
        )
    strategy_of(backend).take(options, control=control, max_cost=max_cost)  # before the first trip
    if deadline is None and max_work is None:
        deadline = DEFAULT_DEADLINE
    begun = time.perf_counter()
    limits = Stop(deadline, parent=stop)
    wishes = {
        "backend": backend,
        "max_work": max_work,
        "seed": seed,
        "control": control,
        "max_cost": None if max_cost is None else max_cost / max(1, len(central.plan.trips)),
        **options,
    }
    trips: list[OwnTrip] = []
    routes: list[list[int]] = []
    for k, route in enumerate(central.plan.routes(instance)):
        left = len(central.plan.trips) - k
        seconds = None if deadline is None else max(LEAST, limits.remaining / left)
        robot = central.plan.trips[k].robot
        trip, own = _own(instance, route, k + 1, robot, _Asker(wishes, seconds, stop, on_progress))
        trips.append(trip)
        routes.append(own)
    return _result(central, backend, routes, trips, time.perf_counter() - begun)


@dataclasses.dataclass(frozen=True, slots=True)
class _Asker:
    """Asks a backend about one trip."""

    wishes: dict[str, Any]
    seconds: float | None
    stop: Stop | None
    listener: Callable[[Progress], None] | None

    def __call__(self, question: Instance, title: str) -> Result:
        """Return the result."""

        def tell(progress: Progress) -> None:
            if self.listener is not None:
                self.listener(dataclasses.replace(progress, step=f"{title}, {progress.step}"))

        return solve(
            question, deadline=self.seconds, stop=self.stop, on_progress=tell, **self.wishes
        )


def _own(
    instance: Instance, route: Sequence[int], number: int, robot: str, ask: _Asker
) -> tuple[OwnTrip, list[int]]:
    """Return what came of a trip, and the nodes in the sequence that is walked."""
    places = _places(instance, route)
    length = instance.route_length(route)
    told = OwnTrip(number, robot, len(places), length, length)

    def kept(reason: str) -> tuple[OwnTrip, list[int]]:
        return dataclasses.replace(told, kept=reason), list(route)

    if ask.stop is not None and ask.stop.requested:
        return kept("interrupted")
    question = _one_trip(instance, [nodes[0] for nodes in places], robot, number)
    try:
        found = ask(question, f"trip {number} of {robot}")
    except (InputError, BackendError, InfeasibleError) as error:
        return kept(_reason(error))
    first = {instance.items[nodes[0] - 1].id: nodes for nodes in places}
    (trip,) = found.plan.trips
    own = [node for name in trip.stops for node in first[name]]
    now = instance.route_length(own)
    if now > length * (1 + TIE) and instance.has_deadlines:
        return kept(f"the own one is {now - length:.12g} longer, and orders have deadlines")
    return dataclasses.replace(told, own=now, sampler=found.sampler), own


def _reason(error: QRobotError) -> str:
    return error.problem if isinstance(error, InputError) else str(error)


def _places(instance: Instance, route: Sequence[int]) -> list[list[int]]:
    """Return the nodes of a trip by their places, which are one stop where no way round pays."""
    if not instance.warehouse.is_metric:
        return [[node] for node in route]
    found: defaultdict[Place, list[int]] = defaultdict(list)
    for node in route:
        found[instance.items[node - 1].place].append(node)
    return list(found.values())


def _one_trip(instance: Instance, nodes: Sequence[int], robot: str, number: int) -> Instance:
    """Return the question of one trip: any sequence is allowed, none is too heavy."""
    items = tuple(
        dataclasses.replace(instance.items[node - 1], weight=Fraction(0), article="", quantity=1)
        for node in sorted(nodes)
    )
    return dataclasses.replace(
        instance,
        items=items,
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=(Robot(robot, 1),),
        name=f"{instance.name}-trip-{number}",
        reference=None,
        remarks=(),
        stock=(),
        times=Times(),
        split=False,
    )


def _result(
    central: Result,
    backend: str,
    routes: Sequence[Sequence[int]],
    trips: Sequence[OwnTrip],
    seconds: float,
) -> Result:
    """Return the checked result of the robots' own sequences."""
    instance, turns = central.instance, Counter[int]()
    place = {robot.id: r for r, robot in enumerate(instance.robots)}
    seats = []
    for trip in central.plan.trips:
        r = place[trip.robot]
        seats.append((r, turns[r]))
        turns[r] += 1
    named = central.plan.objective
    objective = DISTANCE if named == "distance" else objective_named(named)
    plan = Plan.from_routes(instance, routes, objective, seats)
    report = check(plan, instance)
    if not report.ok:
        problems = "; ".join(map(str, report.problems))
        raise BackendError(f"the checker refused the sequences of {backend}: {problems}")
    timing = dataclasses.replace(central.timing, total=central.timing.total + seconds)
    own = EachRobot(backend, central.cost, plan.cost, tuple(trips))
    return dataclasses.replace(
        central,
        plan=plan,
        bound=min(central.bound, plan.cost),
        is_optimal=central.is_optimal and plan.cost <= central.cost * (1 + TIE),
        steps=(*central.steps, f"each robot by {backend}"),
        timing=timing,
        measures=report.measures,
        each_robot=own,
    )
