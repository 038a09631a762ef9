"""A new plan while robots drive: what is on board is brought home, the rest is planned anew.

Robots under way finish their trips: past what is left of the orders that they have begun, by a
shortest way from where they stand. All other orders are planned for the robots as they come back,
beginning with the trips that the old plan had for them; a changed trip costs extra, so that people
and robots keep what they know.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from qrobot._numbers import number
from qrobot._parameters import Parameter
from qrobot._text import count, printable
from qrobot.backends import Stop
from qrobot.errors import InfeasibleError
from qrobot.plan.dealing import Seats
from qrobot.plan.objective import objective_named
from qrobot.planning.bounds import quick_bound, schedule_bound
from qrobot.planning.dispatching import improve
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.result import Result
from qrobot.planning.run import Run, seats_fit
from qrobot.planning.solving import result_of, strategy_of
from qrobot.planning.state import State
from qrobot.planning.strategy import check_arguments
from qrobot.planning.under_way import Finish, cut_off_items, finish
from qrobot.problem import Instance, Order, Robot
from qrobot.problem.fleets import NO_LIMIT

__all__ = ["REPLAN_SCHEMA", "Finish", "Replan", "replan"]

REPLAN_SCHEMA = "qrobot.replan/1"

DEFAULT_SECONDS = 2.0
"""When neither a deadline nor a limit of work is given: robots wait."""


@dataclass(frozen=True, slots=True)
class Replan:
    """What happens from now on.

    Parameters
    ----------
    finishing
        Trips under way.
    result
        The plan of all other orders, an instance of its own: robots are available as they come
        back, times count from the same beginning. ``None`` when no order is left.
    unchanged
        Numbers of the trips of the old plan that stay as they were, with their robots.
    untouched
        Numbers of the trips that nothing forced to change.
    changes
        What is different from the old plan, a sentence each.
    """

    finishing: tuple[Finish, ...]
    result: Result | None
    unchanged: tuple[int, ...]
    untouched: tuple[int, ...]
    changes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data (schema ``qrobot.replan/1``)."""
        return {
            "schema": REPLAN_SCHEMA,
            "finishing": [
                {
                    "robot": one.robot,
                    "trip": one.trip,
                    "picked": list(one.picked),
                    "stops": list(one.stops),
                    "back": one.back,
                }
                for one in self.finishing
            ],
            "unchanged": list(self.unchanged),
            "untouched": list(self.untouched),
            "changes": list(self.changes),
            "plan": None if self.result is None else self.result.to_dict(),
        }

    def summary(self) -> str:
        """Return it in a few plain lines."""
        lines = [
            f"{printable(one.robot)} brings its trip {one.trip} home at {number(one.back)} s, past "
            f"{count(len(one.stops), 'more stop')}"
            for one in self.finishing
        ]
        if self.untouched:
            kept = len(set(self.unchanged) & set(self.untouched))
            lines.append(f"{kept} of {len(self.untouched)} untouched trips stay as they were")
        lines += list(self.changes)
        lines.append("no order is left" if self.result is None else self.result.summary())
        return "\n".join(lines)


def replan(
    state: State,
    *,
    objective: str = "distance",
    stability: float = 1.0,
    deadline: float | None = None,
    max_work: int | None = None,
    seed: int = 0,
) -> Replan:
    """Plan the rest of a plan in progress anew.

    Parameters
    ----------
    state
        What is done, under way and changed.
    objective
        What the plan of the open orders shall have little of; see `solve`.
    stability
        What it costs to change a trip of the old plan that nothing forces to change, in usual
        costs of a trip: 0 changes whatever makes the plan cheaper.
    deadline
        Wall-clock seconds; without it and `max_work`, two seconds.
    max_work
        Limit of work units, for a plan that does not depend on the machine.
    seed
        Of every random choice.

    Raises
    ------
    InputError
        When an argument cannot be used.
    InfeasibleError
        When no plan was found for the open orders.
    """
    check_arguments(deadline=deadline, max_work=max_work, seed=seed, objective=objective)
    Parameter("number", 0, optional=False).check("stability", stability)
    if deadline is None and max_work is None:
        deadline = DEFAULT_SECONDS
    stop = Stop(deadline, max_work)
    aim = objective_named(objective)
    cut_off = cut_off_items(state.instance)
    finishing, notes = finish(state, cut_off)
    instance, more = _open_instance(state, finishing, cut_off)
    notes += more
    if instance is None:
        return Replan(tuple(finishing), None, (), (), tuple(notes))
    if (reason := reason_infeasible(instance)) is not None:
        raise InfeasibleError(reason)
    run = Run(instance, stop, seed, objective=aim, seated=True)
    old = _old_trips(state, instance, finishing)
    routes, seats = _start(instance, old)
    if not seats_fit(instance, routes, seats):
        return _from_nothing(run, finishing, notes)
    run.best.offer(routes, seats=seats)
    index = {order.id: o for o, order in enumerate(instance.orders)}
    fleet = {robot.id: r for r, robot in enumerate(instance.robots)}
    keep = {
        tuple(sorted(index[order] for order in trip.orders)): fleet[trip.robot]
        for trip in old
        if trip.untouched
    }
    run.best.bound = schedule_bound(instance, aim, quick_bound(instance))
    improve(run, routes, seats, keep=keep, stability=stability)
    result = result_of(run, "auto")
    unchanged, changes = _differences(old, result)
    return Replan(
        tuple(finishing),
        result,
        unchanged,
        tuple(trip.number for trip in old if trip.untouched),
        (*notes, *changes),
    )


def _from_nothing(run: Run, finishing: Sequence[Finish], notes: Sequence[str]) -> Replan:
    """Plan all open orders anew, where the old trips do not suit the robots that are left."""
    strategy_of("auto").plan(run)
    note = "the old trips do not suit the robots that are left: all open orders are planned anew"
    return Replan(tuple(finishing), result_of(run, "auto"), (), (), (*notes, note))


# -- what is open -----------------------------------------------------------------------------


def _open_instance(
    state: State, finishing: Sequence[Finish], cut_off: frozenset[str]
) -> tuple[Instance | None, list[str]]:
    """Return the question that is left, ``None`` without orders, and what people must know."""
    instance = state.instance
    notes = [
        f"robot {one.robot} is lost with {len(one.picked)} items: they are collected again"
        for one in state.robots
        if one.lost and one.picked
    ]
    orders, more = _open_orders(state, finishing, cut_off)
    if not orders:
        return None, notes + more
    robots = _open_robots(state, finishing)
    if not robots:
        raise InfeasibleError(f"{len(orders)} orders are open, and no robot may make another trip")
    kept = {item for order in orders for item in order.items}
    question = replace(
        instance,
        items=tuple(item for item in instance.items if item.id in kept),
        orders=tuple(orders),
        robots=tuple(robots),
        reference=None,
    )
    return question, notes + more


def _open_orders(
    state: State, finishing: Sequence[Finish], cut_off: frozenset[str]
) -> tuple[list[Order], list[str]]:
    """Return the orders that nobody has begun, without what is missing, and notes.

    Orders with items that no way leads to have to wait.
    """
    under_way = {order for one in finishing for order in state.plan.trips[one.trip - 1].orders}
    done = under_way | set(state.delivered) | set(state.cancelled)
    missing = set(state.missing)
    orders, notes = [], []
    for order in state.instance.orders:
        if order.id in done:
            continue
        items = tuple(item for item in order.items if item not in missing)
        if absent := [item for item in order.items if item in missing]:
            end = f"goes without {', '.join(absent)}" if items else "is dropped: all is missing"
            notes.append(f"order {order.id} {end}")
        if blocked := [item for item in items if item in cut_off]:
            notes.append(f"order {order.id} has to wait: no way leads to {', '.join(blocked)}")
        elif items:
            orders.append(replace(order, items=items))
    return orders, notes


def _open_robots(state: State, finishing: Sequence[Finish]) -> list[Robot]:
    """Return the robots that may make more trips, available when they are back."""
    lost = {one.robot for one in state.robots if one.lost}
    back = {one.robot: one.back for one in finishing}
    under_way = {one.robot: one.trip for one in state.robots}
    delivered = set(state.delivered)
    begun = Counter(
        trip.robot
        for number, trip in enumerate(state.plan.trips, 1)
        if number == under_way.get(trip.robot) or set(trip.orders) <= delivered
    )
    robots = []
    for robot in state.instance.robots:
        trips = robot.trips if robot.trips == NO_LIMIT else robot.trips - begun[robot.id]
        if robot.id not in lost and trips > 0:
            ready = max(state.now, robot.available, back.get(robot.id, 0.0))
            robots.append(replace(robot, trips=trips, available=ready))
    return robots


@dataclass(frozen=True, slots=True)
class _OldTrip:
    """A trip of the old plan that has not begun, with the orders of it that are open."""

    number: int
    robot: str
    orders: tuple[str, ...]
    stops: tuple[str, ...]
    untouched: bool


def _old_trips(state: State, instance: Instance, finishing: Sequence[Finish]) -> list[_OldTrip]:
    open_orders = {order.id for order in instance.orders}
    items = {item.id for item in instance.items}
    fleet = {robot.id for robot in instance.robots}
    under_way = {one.trip for one in finishing}
    found = []
    for n, trip in enumerate(state.plan.trips, 1):
        orders = tuple(order for order in trip.orders if order in open_orders)
        if n in under_way or not orders:
            continue
        stops = tuple(stop for stop in trip.stops if stop in items)
        whole = orders == trip.orders and stops == trip.stops and trip.robot in fleet
        found.append(_OldTrip(n, trip.robot, orders, stops, whole))
    return found


def _start(instance: Instance, old: Sequence[_OldTrip]) -> tuple[list[list[int]], Seats]:
    """Return the old trips with their robots, and new orders on trips of their own."""
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    routes = [[node[stop] for stop in trip.stops] for trip in old]
    known = {order for trip in old for order in trip.orders}
    fleet = {robot.id: r for r, robot in enumerate(instance.robots)}
    owners: list[int | None] = [fleet.get(trip.robot) for trip in old]
    for order, nodes in zip(instance.orders, instance.order_nodes, strict=True):
        if order.id not in known:
            routes.append(list(nodes))
            owners.append(None)
    seats: Seats = []
    turns = [0] * len(instance.robots)
    loads = [sum(int(instance.weights[v - 1]) for v in route) for route in routes]
    for owner, load in zip(owners, loads, strict=True):
        able = [
            r
            for r, room in enumerate(instance.capacities.tolist())
            if load <= room and turns[r] < instance.robots[r].trips
        ]
        r = owner if owner in able else min(able, key=lambda r: turns[r], default=0)
        assert r is not None
        seats.append((r, turns[r]))
        turns[r] += 1
    return routes, seats


# -- what changed -----------------------------------------------------------------------------


def _differences(old: Sequence[_OldTrip], result: Result) -> tuple[tuple[int, ...], list[str]]:
    """Return the trips that stay as they were, and a sentence for each other trip of the plan."""
    new = {frozenset(trip.orders): trip for trip in result.plan.trips}
    unchanged = tuple(
        trip.number
        for trip in old
        if trip.untouched
        and (same := new.get(frozenset(trip.orders))) is not None
        and same.robot == trip.robot
    )
    before = {order: trip for trip in old for order in trip.orders}
    known = {frozenset(trip.orders) for trip in old if trip.number in unchanged}
    changes = []
    for n, trip in enumerate(result.plan.trips, 1):
        if frozenset(trip.orders) in known:
            continue
        parts: dict[str, list[str]] = {}
        for order in trip.orders:
            came = before.get(order)
            if came is None:
                origin = "new"
            else:
                origin = "as before" if came.robot == trip.robot else f"from {came.robot}"
            parts.setdefault(origin, []).append(order)
        told = "; ".join(f"{origin} {', '.join(orders)}" for origin, orders in parts.items())
        changes.append(f"trip {n} of {trip.robot}: {told}")
    return unchanged, changes
