"""A plan in progress: what is delivered, what is on board, where robots are; schema and checks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from qrobot._files import StrPath, read_text, write_text_atomic
from qrobot.errors import InputError
from qrobot.plan import Plan, as_picked, check
from qrobot.plan.timing import spans, timed
from qrobot.problem import Instance
from qrobot.problem.formats.jsontext import dumps, loads, located
from qrobot.problem.formats.native import instance_of_data, to_text

__all__ = ["STATE_SCHEMA", "RobotState", "State", "read_state", "state_at"]

STATE_SCHEMA = "qrobot.state/1"

_ADVICE = "correct the state, or make it anew (qrobot state)"


@dataclass(frozen=True, slots=True)
class RobotState:
    """What a robot is doing.

    Parameters
    ----------
    robot
        Its id.
    trip
        Number of its trip under way in the plan, from 1; 0 at the depot.
    picked
        Ids of the items of that trip that are on board, in sequence.
    back
        When it is back if nothing changes, seconds since all robots began; of a robot at the
        depot, when it may leave.
    lost
        Whether it has broken down: what is on board must be collected again by others.
    """

    robot: str
    trip: int = 0
    picked: tuple[str, ...] = ()
    back: float = 0.0
    lost: bool = False


@dataclass(frozen=True, slots=True)
class State:
    """A plan in progress at a moment, and what has changed.

    Parameters
    ----------
    instance
        All orders, new ones too, and the warehouse as it is now.
    plan
        Who was to collect what; it knows nothing of new orders.
    now
        Seconds since all robots began.
    delivered
        Ids of the orders that are back.
    robots
        What each robot is doing; those that are not named stand at the depot.
    cancelled
        Ids of orders that nobody wants any more.
    missing
        Ids of items that are not where they should be (short picks).
    """

    instance: Instance
    plan: Plan
    now: float
    delivered: tuple[str, ...] = ()
    robots: tuple[RobotState, ...] = ()
    cancelled: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what contradicts the plan or the instance."""
        _check(self)

    def to_dict(self) -> dict[str, Any]:
        """Return the state as plain data (schema ``qrobot.state/1``)."""
        return {
            "schema": STATE_SCHEMA,
            "now": self.now,
            "delivered": list(self.delivered),
            "robots": [
                {
                    "robot": one.robot,
                    "trip": one.trip,
                    "picked": list(one.picked),
                    "back": one.back,
                    "lost": one.lost,
                }
                for one in self.robots
            ],
            "cancelled": list(self.cancelled),
            "missing": list(self.missing),
            "plan": self.plan.to_dict(),
            "instance": loads(to_text(self.instance)),
        }

    def save(self, path: StrPath) -> None:
        """Write the state as JSON; never leaves a half-written file."""
        write_text_atomic(path, dumps(self.to_dict()))


def state_at(plan: Plan, instance: Instance, now: float) -> State:
    """Return the state of a plan at a moment, if all goes as planned.

    Parameters
    ----------
    plan
        Accepted by the checker; its trips are walked by shortest ways.
    instance
        The question.
    now
        Seconds since all robots began.

    Raises
    ------
    InputError
        When the plan is not right for the instance, or `now` is no moment.
    """
    if not (math.isfinite(now) and now >= 0):
        raise InputError(f"{now!r} is not a moment", field="now", advice="give seconds from 0")
    if plan.routing != "exact":
        raise InputError(
            f"the plan walks by {plan.routing}",
            field="routing",
            advice="replan shortest tours only",
        )
    if not (report := check(plan, instance)).ok:
        raise InputError(f"the plan is not right: {report.problems[0]}", advice="make it anew")
    instance = as_picked(instance, plan.picks, with_stock=False)
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    delivered: list[str] = []
    robots = []
    for robot in instance.robots:
        own = [(n, trip) for n, trip in enumerate(plan.trips, 1) if trip.robot == robot.id]
        routes = [[node[stop] for stop in trip.stops] for _, trip in own]
        doing = RobotState(robot.id, back=robot.available)
        times = spans([timed(instance, route) for route in routes], robot)
        for (number, trip), route, (begins, ends) in zip(own, routes, times, strict=True):
            if ends <= now:
                delivered += trip.orders
                doing = replace(doing, back=ends)
            elif begins <= now:
                picked = _picked(instance, route, begins, robot.speed, now)
                doing = RobotState(robot.id, number, trip.stops[:picked], ends)
        robots.append(doing)
    return State(instance, plan, now, tuple(delivered), tuple(robots))


def _picked(
    instance: Instance, route: Sequence[int], begins: float, speed: float, now: float
) -> int:
    """Return how many items of a trip are on board."""
    clock, at, done = begins + instance.times.per_trip, 0, 0
    for v in route:
        way = instance.place_distances[instance.place_of_node[at], instance.place_of_node[v]]
        clock += float(way) / speed + instance.times.of(instance.items[v - 1])
        if clock > now:
            return done
        at, done = v, done + 1
    return done


def _check(state: State) -> None:
    if not (math.isfinite(state.now) and state.now >= 0):
        raise _wrong("now", f"{state.now!r} is not a moment")
    items = {item.id for item in state.instance.items}
    orders = {order.id for order in state.instance.orders}
    for field, names, known in (
        ("delivered", state.delivered, orders),
        ("cancelled", state.cancelled, orders),
        ("missing", state.missing, items),
    ):
        for i, name in enumerate(names):
            if name not in known:
                raise _wrong(f"{field}[{i}]", f"{name!r} is not in the instance")
    for i, name in enumerate(state.cancelled):
        if name in state.delivered:
            raise _wrong(f"cancelled[{i}]", f"order {name} is delivered already")
    for n, trip in enumerate(state.plan.trips):
        for stop in trip.stops:
            if stop not in items:
                raise _wrong(f"plan.trips[{n}]", f"item {stop!r} is not in the instance")
    fleet = {robot.id for robot in state.instance.robots}
    named: set[str] = set()
    for i, one in enumerate(state.robots):
        if one.robot not in fleet or one.robot in named:
            problem = "is named twice" if one.robot in fleet else "is not in the instance"
            raise _wrong(f"robots[{i}]", f"robot {one.robot!r} {problem}")
        named.add(one.robot)
        _check_robot(state, one, f"robots[{i}]")


def _check_robot(state: State, one: RobotState, at: str) -> None:
    trips = state.plan.trips
    if not 0 <= one.trip <= len(trips):
        raise _wrong(f"{at}.trip", f"the plan has no trip {one.trip}")
    if one.trip == 0:
        if one.picked:
            raise _wrong(f"{at}.picked", f"robot {one.robot} carries items without a trip")
        return
    trip = trips[one.trip - 1]
    if trip.robot != one.robot:
        raise _wrong(f"{at}.trip", f"trip {one.trip} is that of robot {trip.robot}")
    for item in one.picked:
        if item not in trip.stops:
            raise _wrong(f"{at}.picked", f"item {item!r} is not on trip {one.trip}")
        if item in state.missing:
            raise _wrong(f"{at}.picked", f"item {item!r} is on board and missing")
    if both := [order for order in trip.orders if order in state.delivered]:
        raise _wrong(f"{at}.trip", f"order {both[0]} is delivered and still under way")


def _wrong(field: str, problem: str) -> InputError:
    return InputError(problem, field=field, advice=_ADVICE)


def read_state(path: StrPath) -> State:
    """Read a state that `State.save` or ``qrobot state`` wrote, maybe changed by hand.

    Raises
    ------
    InputError
        When the file is not a state, or contradicts its plan.
    """
    text = read_text(path)
    try:
        with located(text):
            data = loads(text)
            return _state(data)
    except InputError as error:
        raise error.in_file(str(path)) from None


def _state(data: Any) -> State:
    if not isinstance(data, Mapping):
        raise InputError("not a state", advice=_ADVICE)
    if data.get("schema") != STATE_SCHEMA:
        raise InputError(
            f"unknown schema {data.get('schema')!r}",
            field="schema",
            advice=f"this version reads {STATE_SCHEMA!r}",
        )
    known = {"schema", "now", "delivered", "robots", "cancelled", "missing", "plan", "instance"}
    for name in data:
        if name not in known:
            raise _wrong(name, "is not a known field")
    for name in ("now", "plan", "instance"):
        if name not in data:
            raise _wrong(name, "is missing")
    try:
        instance = instance_of_data(data["instance"])
    except InputError as error:
        raise error.at(f"instance.{error.field}" if error.field else "instance") from None
    robots = data.get("robots", [])
    if not isinstance(robots, list):
        raise _wrong("robots", "is not a list")
    return State(
        instance=instance,
        plan=Plan.from_dict(data["plan"]),
        now=_seconds(data["now"], "now"),
        delivered=_names(data, "delivered"),
        robots=tuple(_robot(one, f"robots[{i}]") for i, one in enumerate(robots)),
        cancelled=_names(data, "cancelled"),
        missing=_names(data, "missing"),
    )


def _robot(one: Any, at: str) -> RobotState:
    if not isinstance(one, Mapping) or not isinstance(one.get("robot"), str):
        raise _wrong(at, "is not an object with a robot")
    trip, lost = one.get("trip", 0), one.get("lost", False)
    if isinstance(trip, bool) or not isinstance(trip, int):
        raise _wrong(f"{at}.trip", f"{trip!r} is not the number of a trip")
    if not isinstance(lost, bool):
        raise _wrong(f"{at}.lost", f"{lost!r} is not true or false")
    back = _seconds(one.get("back", 0.0), f"{at}.back")
    return RobotState(one["robot"], trip, _names(one, "picked", at), back, lost)


def _seconds(value: Any, field: str) -> float:
    if isinstance(value, bool):
        raise _wrong(field, f"{value!r} is not seconds")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise _wrong(field, f"{value!r:.40} is not seconds") from None


def _names(data: Mapping[str, Any], name: str, at: str = "") -> tuple[str, ...]:
    value = data.get(name, [])
    field = f"{at}.{name}" if at else name
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise _wrong(field, "is not a list of names")
    return tuple(value)
