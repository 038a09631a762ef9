"""The answer: trips, each of one robot, each from the depot and back."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar

from qrobot._notebook import html_table, shown_name
from qrobot._numbers import number
from qrobot.errors import InputError
from qrobot.plan.dealing import Seats, assign, cost
from qrobot.plan.objective import DISTANCE, Objective, objective_named
from qrobot.plan.picks import Pick, picks_of
from qrobot.problem.checks import canonical
from qrobot.problem.entities import Robot
from qrobot.problem.instance import Instance

__all__ = ["PLAN_SCHEMA", "TABLE_HEADS", "Plan", "Trip"]

PLAN_SCHEMA = "qrobot.plan/1"

TABLE_HEADS = ("trip", "robot", "load", "distance", "orders", "stops in sequence")

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True, repr=False)
class Trip:
    """One way of one robot: out of the depot, past its stops in sequence, and back.

    Parameters
    ----------
    robot
        Id of the robot.
    orders
        Ids of the orders it collects, sorted by first stop.
    stops
        Ids of the items in the sequence of collection.
    distance
        Length of the way with both legs to the depot, metres.
    load
        Weight carried at the end, in the unit of the input.
    seconds
        Driving time at the robot's speed.
    labels
        Of the bins of the stops, in the same sequence; empty where no stop has one.
    """

    robot: str
    orders: tuple[str, ...]
    stops: tuple[str, ...]
    distance: float
    load: float
    seconds: float
    labels: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"<Trip of {shown_name(self.robot)}: {len(self.stops)} stops, "
            f"distance {number(self.distance)}, load {number(self.load)}>"
        )

    def named_stops(self) -> list[str]:
        """Return the stops as people look for them: the item's id, and the bin where it has one."""
        labels = self.labels or ("",) * len(self.stops)
        return [
            f"{stop} ({label})" if label else stop
            for stop, label in zip(self.stops, labels, strict=True)
        ]


@dataclass(frozen=True, slots=True, repr=False)
class Plan:
    """Trips that together answer an instance. Robots without a trip stay home.

    Parameters
    ----------
    trips
        The trips, by robot in the instance's sequence.
    distance
        Total distance, metres.
    instance
        Name of the instance.
    split
        Whether orders were allowed to be split (each item stood alone).
    objective
        Name of the objective that it was made for.
    value
        What it costs by that objective; ``None``: its distance.
    picks
        What is taken from which place, of articles that have a stock.
    routing
        How trips are walked: by shortest ways from stop to stop (``exact``), or by a policy.
    """

    trips: tuple[Trip, ...]
    distance: float
    instance: str = "instance"
    split: bool = False
    objective: str = "distance"
    value: float | None = None
    picks: tuple[Pick, ...] = ()
    routing: str = "exact"

    @property
    def cost(self) -> float:
        """What the plan costs by its objective."""
        return self.distance if self.value is None else self.value

    def __repr__(self) -> str:
        return f"<Plan of {self._headline()}>"

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        return html_table(f"Plan of {self._headline()}", TABLE_HEADS, self.rows())

    def _headline(self) -> str:
        stops = sum(len(trip.stops) for trip in self.trips)
        return (
            f"{shown_name(self.instance)}: {len(self.trips)} trips, {stops} stops, "
            f"distance {number(self.distance)}"
        )

    def rows(self) -> list[tuple[str, ...]]:
        """Return the cells of a table with the heads `TABLE_HEADS`, a row a trip."""
        return [
            (
                str(place),
                trip.robot,
                number(trip.load),
                number(trip.distance),
                str(len(trip.orders)),
                " ".join(trip.named_stops()),
            )
            for place, trip in enumerate(self.trips, 1)
        ]

    @classmethod
    def from_routes(
        cls,
        instance: Instance,
        routes: Sequence[Sequence[int]],
        objective: Objective = DISTANCE,
        seats: Seats | None = None,
    ) -> Plan:
        """Make a plan from routes of nodes.

        Parameters
        ----------
        instance
            The question.
        routes
            For each trip its nodes (item index + 1) in sequence; empty ones are dropped.
        objective
            What the plan costs.
        seats
            Who makes each trip, and as which of its own; by default as `dealing.assign` says.
        """
        kept = [[int(v) for v in route] for route in routes if len(route)]
        if seats is None:
            seats = assign(instance, kept, objective)
        trips = [
            (seat, _trip(instance, route, instance.robots[seat[0]]))
            for seat, route in zip(seats, kept, strict=True)
        ]
        trips.sort(key=lambda t: t[0])
        return cls(
            trips=tuple(trip for _, trip in trips),
            distance=float(sum(trip.distance for _, trip in trips)),
            instance=instance.name,
            split=instance.split,
            objective=objective.name,
            value=None if objective is DISTANCE else cost(instance, kept, objective, seats),
            picks=picks_of(instance),
            routing=instance.routing,
        )

    def routes(self, instance: Instance) -> list[list[int]]:
        """Return the trips as nodes (item index + 1) of the instance."""
        node = {item.id: i + 1 for i, item in enumerate(instance.items)}
        return [[node[stop] for stop in trip.stops] for trip in self.trips]

    @property
    def robots_used(self) -> int:
        """Number of different robots that leave the depot."""
        return len({trip.robot for trip in self.trips})

    def to_dict(self) -> dict[str, Any]:
        """Return the plan as plain data (schema ``qrobot.plan/1``)."""
        return {
            "schema": PLAN_SCHEMA,
            "instance": self.instance,
            "split_orders": self.split,
            "routing": self.routing,
            "distance": self.distance,
            "objective": self.objective,
            "cost": self.cost,
            "trips": [
                {
                    "robot": t.robot,
                    "orders": list(t.orders),
                    "stops": list(t.stops),
                    "distance": t.distance,
                    "load": t.load,
                    "seconds": t.seconds,
                    "labels": list(t.labels),
                }
                for t in self.trips
            ],
            "picks": [pick.to_dict() for pick in self.picks],
        }

    @classmethod
    def from_dict(cls, data: Any, *, source: str | None = None) -> Plan:
        """Read a plan from plain data.

        Raises
        ------
        InputError
            When the data is not a plan of schema ``qrobot.plan/1``.
        """
        if not isinstance(data, dict):
            raise InputError("not a plan", source=source, advice="give a plan that qrobot wrote")
        if data.get("schema") != PLAN_SCHEMA:
            raise InputError(
                f"unknown schema {data.get('schema')!r}",
                source=source,
                field="schema",
                advice=f"this version reads {PLAN_SCHEMA!r}",
            )
        top = _Fields(data, "", source)
        trips = []
        for i, one in enumerate(top.take("trips", _list)):
            trip = _Fields(one, f"trips[{i}]", source)
            trips.append(
                Trip(
                    robot=trip.take("robot", _text),
                    orders=trip.take("orders", _texts),
                    stops=trip.take("stops", _texts),
                    distance=trip.take("distance", _number),
                    load=trip.take("load", _number),
                    seconds=trip.take("seconds", _number, 0.0),
                    labels=trip.take("labels", _texts, ()),
                )
            )
            if len(trips[-1].labels) not in (0, len(trips[-1].stops)):
                raise trip.error("does not have a label for each stop", f"{trip.path}.labels")
        objective = objective_named(top.take("objective", _text, "distance")).name
        distance = top.take("distance", _number)
        value = top.take("cost", _number, distance if objective == "distance" else None)
        return cls(
            trips=tuple(trips),
            distance=distance,
            instance=top.take("instance", _text, "instance"),
            split=top.take("split_orders", _flag, False),
            objective=objective,
            value=None if objective == "distance" and value == distance else value,
            picks=top.take("picks", _picks, ()),
            routing=top.take("routing", _text, "exact"),
        )


def _trip(instance: Instance, nodes: Sequence[int], robot: Robot) -> Trip:
    length = instance.route_length(nodes)
    orders = dict.fromkeys(instance.orders[instance.order_of_node[v]].id for v in nodes)
    load = int(sum(instance.weights[v - 1] for v in nodes))
    labels = tuple(instance.items[v - 1].label for v in nodes)
    return Trip(
        robot=robot.id,
        orders=tuple(orders),
        stops=tuple(instance.items[v - 1].id for v in nodes),
        distance=length,
        load=float(load * instance.unit),
        seconds=length / robot.speed,
        labels=labels if any(labels) else (),
    )


@dataclass(frozen=True, slots=True)
class _Fields:
    """An object of a plan's data, and the path to it."""

    data: Any
    path: str
    source: str | None

    def take(self, name: str, convert: Callable[[Any], _T], default: _T | None = None) -> _T:
        """Return a field, converted; errors name its path."""
        if not isinstance(self.data, dict):
            raise self.error("is malformed (not an object)", self.path)
        field = f"{self.path}.{name}" if self.path else name
        if name not in self.data:
            if default is None:
                raise self.error("is missing", field)
            return default
        try:
            return convert(self.data[name])
        except (TypeError, ValueError) as error:
            raise self.error(f"is malformed ({error})", field) from None

    def error(self, problem: str, field: str) -> InputError:
        """Return an error of this file."""
        return InputError(
            problem, source=self.source, field=field, advice="give a plan that qrobot wrote"
        )


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.40} is not text")
    return canonical(value)


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError(f"{value!r:.40} is not a list")
    return value


def _texts(value: Any) -> tuple[str, ...]:
    return tuple(map(_text, _list(value)))


def _picks(value: Any) -> tuple[Pick, ...]:
    try:
        return tuple(map(Pick.from_dict, _list(value)))
    except KeyError as error:
        raise TypeError(f"{error} is missing") from None


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{value!r:.40} is not true or false")
    return value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal | Fraction):
        raise TypeError(f"{value!r:.40} is not a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError("a number is not finite, or too large")
    return number
