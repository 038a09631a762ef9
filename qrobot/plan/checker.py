"""The checker that trusts no solver.

It takes a plan and the question and recomputes everything a plan claims, by itself: loads
as exact fractions, distances in plain Python (`ruler`). No code of `models`, `backends` or
`planning` and no derived number of the instance takes part, so that a fault there cannot
hide itself here.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any, Literal

from qrobot.plan.clock import Measures, measure
from qrobot.plan.objective import MEASURES, OBJECTIVES
from qrobot.plan.picks import as_picked
from qrobot.plan.plan import Plan, Trip
from qrobot.plan.ruler import Ruler
from qrobot.plan.rules import rule_of
from qrobot.problem.entities import Item, Robot
from qrobot.problem.instance import Instance
from qrobot.problem.warehouse import Place

__all__ = ["CheckReport", "Problem", "check"]

RELATIVE = 1e-6
ABSOLUTE = 1e-9

Kind = Literal[
    "missing", "repeated", "unknown", "orders", "split", "overload", "load", "robot", "turns",
    "empty", "unreachable", "distance", "time", "total", "cost", "stock", "quantity", "routing",
    "deadline", "label",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a plan.

    Parameters
    ----------
    kind
        ``missing``, ``repeated`` or ``unknown`` items; ``orders`` listed that do not agree
        with the stops; ``split`` orders; ``overload``; a wrong ``load`` or ``distance``;
        an unknown ``robot``; too many ``turns`` of one; an ``empty`` trip; an
        ``unreachable`` stop (a way that does not exist); a wrong driving ``time``; a wrong
        ``total``, or ``cost`` by the objective; more taken from a place than its ``stock``; a
        ``quantity`` of an article that is not what an order asks for; a ``routing`` that is not
        a policy for this warehouse, or stops in a sequence that it does not take; an order that
        is back after its ``deadline``; a ``label`` that the bin of a stop does not have.
    text
        One sentence with the numbers.
    """

    kind: Kind
    text: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True)
class CheckReport:
    """What the checker found.

    Parameters
    ----------
    problems
        Everything that is wrong; empty for a right plan.
    trips, stops
        How much was checked.
    distance
        The total distance that the checker measured; ``nan`` when it could not.
    objective, cost
        The plan's objective, and its value by the checker's own distances.
    measures
        What the plan comes to by every measure: metres, seconds, lateness, trips, robots.
    """

    problems: tuple[Problem, ...]
    trips: int = 0
    stops: int = 0
    distance: float = math.nan
    objective: str = "distance"
    cost: float = math.nan
    measures: Measures | None = field(default=None, repr=False)

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems

    def __str__(self) -> str:
        if self.ok:
            text = f"right: {self.trips} trips, {self.stops} stops, distance {self.distance:.12g}"
            other = self.objective != "distance"
            return f"{text}, {self.objective} {self.cost:.12g}" if other else text
        return "\n".join(f"{p.kind}: {p.text}" for p in self.problems)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return {
            "ok": self.ok,
            "trips": self.trips,
            "stops": self.stops,
            "distance": self.distance if math.isfinite(self.distance) else None,
            "objective": self.objective,
            "cost": self.cost if math.isfinite(self.cost) else None,
            "measures": self.measures.to_dict()
            if self.measures is not None and math.isfinite(self.distance)
            else None,
            "problems": [{"kind": p.kind, "text": p.text} for p in self.problems],
        }


def check(plan: Plan, instance: Instance) -> CheckReport:
    """Verify a plan against the question, without any solver's code.

    Parameters
    ----------
    plan
        The answer.
    instance
        The question; when its orders were split (`Instance.split_orders`), items of one
        order may be on several trips.

    Returns
    -------
    CheckReport
        Every item is collected once; whole orders are on one trip, and those listed agree
        with the stops; no load exceeds its robot's capacity (exact fractions); robots are
        known and make no more trips than they may; no trip is empty; loads, driving times,
        the distance of every trip, the total and the cost by the plan's objective are stated
        right (relative tolerance 1e-6); every way exists; no order is back after its deadline; of
        articles with a stock no place gives more than it has, and each order gets what it asks for.
        Under a routing policy distances are those of its ways, in which the stops have their
        sequence. A driving time of 0 counts as not stated.
    """
    problems = list(_stock(plan, instance))
    instance = as_picked(instance, plan.picks, with_stock=False)
    problems += [*_items(plan, instance), *_orders(plan, instance), *_robots(plan, instance)]
    robots = {robot.id: robot for robot in instance.robots}
    items = {item.id: item for item in instance.items}
    ruler = Ruler(instance.warehouse)
    both_ways = ruler.both_ways()
    rule = None
    if plan.routing != "exact":
        rule, reason = rule_of(plan.routing, instance.warehouse)
        if rule is None:
            problems.append(Problem("routing", f"the routing {plan.routing!r} {reason}"))
    lengths: list[float] = []
    for number, trip in enumerate(plan.trips, 1):
        stops = [stop for stop in trip.stops if stop in items]  # the others are reported above
        load = sum((items[stop].weight for stop in stops), Fraction(0))
        length = ruler.trip(items[stop].place for stop in stops)
        if rule is not None:
            direct, length = length, rule(items[stop].place for stop in stops)
            problems += _sequence(number, plan.routing, direct, length)
        lengths.append(length)
        robot = robots.get(trip.robot)
        both = None if both_ways is None else both_ways.trip(items[stop].place for stop in stops)
        problems += [*_labels(number, trip, items), *_trip(number, trip, load, length, robot, both)]
        if math.isinf(length):
            problems += _forbidden(number, [items[stop] for stop in stops], ruler)
    measures = measure(instance, plan.trips, lengths)
    total, cost = measures.distance, _cost(plan, instance, measures, lengths)
    if math.isfinite(total):
        problems += _deadlines(instance, measures)
    if math.isfinite(total) and not _agree(plan.distance, total):
        problems.append(
            Problem(
                "total", f"the plan states a total distance of {plan.distance!r}, it is {total!r}"
            )
        )
    if plan.value is not None and math.isfinite(cost) and not _agree(plan.value, cost):
        problems.append(
            Problem("cost", f"the plan states a {plan.objective} of {plan.value!r}, it is {cost!r}")
        )
    return CheckReport(
        problems=tuple(problems),
        trips=len(plan.trips),
        stops=sum(len(trip.stops) for trip in plan.trips),
        distance=total,
        objective=plan.objective,
        cost=cost,
        measures=measures,
    )


def _cost(plan: Plan, instance: Instance, measures: Measures, lengths: Sequence[float]) -> float:
    """Return what the plan costs by its objective, ``nan`` when a robot is not known."""
    robots = {robot.id: robot for robot in instance.robots}
    items = {item.id: item for item in instance.items}
    if any(trip.robot not in robots for trip in plan.trips):
        return math.nan
    cost = 0.0
    for part in plan.objective.split(","):
        name, _, weight = part.partition("=")
        if name in MEASURES:
            value = measures.value(name)
        else:  # an entry of somebody's own: its prices, with the lengths measured here
            one = OBJECTIVES[name]
            value = one.per_robot * measures.robots
            value += one.makespan * measures.makespan + one.lateness * measures.lateness
            for trip, length in zip(plan.trips, lengths, strict=True):
                picked = [items[stop] for stop in trip.stops if stop in items]
                value += one.trip(length, robots[trip.robot], picked, instance.times)
        cost += float(weight or 1.0) * value
    return cost


def _deadlines(instance: Instance, measures: Measures) -> Iterator[Problem]:
    for order in instance.orders:
        back = measures.back.get(order.id, 0.0)
        if back > order.deadline and not _agree(back, order.deadline):
            yield Problem(
                "deadline",
                f"order {order.id} is back after {back:.12g} s, its deadline is "
                f"{order.deadline:.12g} s",
            )


def _stock(plan: Plan, instance: Instance) -> Iterator[Problem]:
    """Compare what is taken from places with what lies there, and with what orders ask for."""
    if not plan.picks:
        return
    there = {(one.article, one.place): one.quantity for one in instance.stock}
    known = {one.article for one in instance.stock}
    owner = {item: order.id for order in instance.orders for item in order.items}
    balance = Counter[tuple[str, str]]()
    for item in instance.items:
        if item.article in known:
            balance[owner[item.id], item.article] += item.quantity
    asked = dict(balance)
    taken = Counter[tuple[str, Place]]()
    for pick in plan.picks:
        balance[pick.order, pick.article] -= pick.quantity
        taken[pick.article, pick.place] += pick.quantity
    for (order, article), missing in balance.items():
        if missing:
            wanted = asked.get((order, article), 0)
            yield Problem(
                "quantity",
                f"order {order} asks for {wanted} pieces of article {article}, the plan takes "
                f"{wanted - missing}",
            )
    for (article, place), pieces in taken.items():
        if pieces > there.get((article, place), 0):
            yield Problem(
                "stock",
                f"{pieces} pieces of article {article} are taken from {place}, "
                f"{there.get((article, place), 0)} are there",
            )


def _items(plan: Plan, instance: Instance) -> Iterator[Problem]:
    visits = Counter(stop for trip in plan.trips for stop in trip.stops)
    known = {item.id for item in instance.items}
    if missing := [item.id for item in instance.items if item.id not in visits]:
        yield Problem("missing", f"nobody collects {_some('item', missing)}")
    if repeated := [f"{name} ({n} times)" for name, n in visits.items() if n > 1]:
        yield Problem("repeated", f"more than once is collected: {_some('item', repeated)}")
    if unknown := [name for name in visits if name not in known]:
        yield Problem("unknown", f"not in the instance: {_some('item', unknown)}")


def _orders(plan: Plan, instance: Instance) -> Iterator[Problem]:
    if plan.split and not instance.split:
        yield Problem("split", "the plan was made with split orders, the instance keeps them whole")
    elif instance.split and not plan.split:
        yield Problem("orders", "the plan was made with whole orders, the instance splits them")
    owner = {item: order.id for order in instance.orders for item in order.items}
    trips_of: defaultdict[str, set[int]] = defaultdict(set)
    for number, trip in enumerate(plan.trips, 1):
        served = {owner[stop] for stop in trip.stops if stop in owner}
        listed = Counter(trip.orders)
        for name in served:
            trips_of[name].add(number)
        if absent := sorted(served - set(listed)):
            yield Problem("orders", f"trip {number} does not list {_some('order', absent)}")
        if extra := sorted(set(listed) - served):
            yield Problem(
                "orders", f"trip {number} collects nothing of the listed {_some('order', extra)}"
            )
        if twice := sorted(name for name, n in listed.items() if n > 1):
            yield Problem("orders", f"trip {number} lists twice: {_some('order', twice)}")
    for order in instance.orders:
        if len(trips := sorted(trips_of[order.id])) > 1:
            on = ", ".join(map(str, trips))
            yield Problem("split", f"order {order.id} is split over the trips {on}")


def _robots(plan: Plan, instance: Instance) -> Iterator[Problem]:
    allowed = {robot.id: robot.trips for robot in instance.robots}
    for name, trips in Counter(trip.robot for trip in plan.trips).items():
        if name not in allowed:
            yield Problem("robot", f"robot {name} is not in the instance")
        elif trips > allowed[name]:
            yield Problem("turns", f"robot {name} makes {trips} trips, {allowed[name]} allowed")


def _trip(
    number: int,
    trip: Trip,
    load: Fraction,
    length: float,
    robot: Robot | None,
    both_ways: float | None,
) -> Iterator[Problem]:
    if not trip.stops:
        yield Problem("empty", f"trip {number} of robot {trip.robot} has no stops")
    if robot is not None and load > robot.capacity:
        yield Problem(
            "overload",
            f"trip {number} carries {float(load):.12g}, robot {robot.id} holds "
            f"{float(robot.capacity):.12g}",
        )
    if not _agree(trip.load, float(load)):
        yield Problem(
            "load", f"trip {number} states a load of {trip.load!r}, it is {float(load)!r}"
        )
    if math.isinf(length):
        return  # there is no distance to compare with: `_forbidden` reports it
    if not _agree(trip.distance, length):
        text = f"trip {number} states a distance of {trip.distance!r}, it is {length!r}"
        if both_ways is not None and _agree(trip.distance, both_ways):
            text += ": the stated one goes against one-way aisles"
        yield Problem("distance", text)
    elif robot is not None and trip.seconds and not _agree(trip.seconds, length / robot.speed):
        yield Problem(
            "time",
            f"trip {number} states {trip.seconds!r} s, at {robot.speed:.12g} m/s it takes "
            f"{length / robot.speed!r} s",
        )


def _labels(number: int, trip: Trip, items: Mapping[str, Item]) -> Iterator[Problem]:
    """Compare the labels of a trip, where it states some, with those of its stops."""
    for stop, label in zip(trip.stops, trip.labels, strict=False):
        if stop in items and label != items[stop].label:
            right = items[stop].label
            yield Problem(
                "label",
                f"trip {number} names the bin {label!r} for item {stop}, "
                + (f"it is {right!r}" if right else "which has no label"),
            )


def _sequence(number: int, routing: str, direct: float, length: float) -> Iterator[Problem]:
    """Compare the shortest ways from stop to stop with the way of the policy past all of them."""
    if direct > length and not _agree(direct, length):
        yield Problem(
            "routing",
            f"trip {number} needs {direct!r} for its stops in this sequence, the way of {routing} "
            f"past them is {length!r}",
        )


def _forbidden(number: int, stops: Sequence[Item], ruler: Ruler) -> Iterator[Problem]:
    """Name the ways of a trip that do not exist."""
    names = ["depot", *(item.id for item in stops), "depot"]
    corners = [None, *(item.place for item in stops), None]
    missing = [
        f"from {a} to {b}"
        for (a, b), (start, end) in zip(pairwise(names), pairwise(corners), strict=True)
        if math.isinf(ruler.leg(start, end))
    ]
    yield Problem("unreachable", f"trip {number}: no way leads directly{_some('', missing)}")


def _agree(stated: float, measured: float) -> bool:
    return math.isclose(stated, measured, rel_tol=RELATIVE, abs_tol=ABSOLUTE)


def _some(what: str, names: Sequence[str], most: int = 5) -> str:
    shown = ", ".join(names[:most])
    rest = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{what}{'s' if what and len(names) > 1 else ''} {shown}{rest}"
