"""Which order a robot should collect next, from where it stands: scenario 1 of the paper."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from qrobot._parameters import near
from qrobot.backends import Stop
from qrobot.backends.classical.batching import tour_length
from qrobot.backends.classical.exact.tours import best_sequence
from qrobot.errors import InfeasibleError, InputError
from qrobot.problem import Instance, Node, Place, Point, Pose, Robot, Slot

__all__ = ["DEFAULT_SECONDS", "RankedOrder", "rank_orders"]

DEFAULT_SECONDS = 10.0
"""When no stop is given: from then on ways are good ones, not proven shortest ones."""

DIGITS = 9
"""Decimals of metres in which ways differ; less is rounding."""

FORMS = {
    "aisles": "a slot as AISLE,SLOT or AISLE,SLOT,BLOCK",
    "matrix": "the number of a node",
    "map": "the name of a pose, or coordinates as X,Y",
    "lanes": "the name of a pose",
}
"""How places are written, by the kind of warehouse."""


@dataclass(frozen=True, slots=True)
class RankedOrder:
    """What it costs a robot to collect one order on its way to the depot.

    Parameters
    ----------
    order
        Its id.
    extra
        By how much the way is longer than going to the depot at once, metres; all of it where
        no way leads there at once.
    distance
        From where the robot stands, past all items, to the depot; ``inf`` where no way leads.
    seconds
        To drive and collect.
    load
        Weight of the order, exact.
    items
        Ids of its items in the sequence of the way.
    is_shortest
        Whether the way is proven to be a shortest one.
    """

    order: str
    extra: float
    distance: float
    seconds: float
    load: Fraction
    items: tuple[str, ...]
    is_shortest: bool

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "order": self.order,
            "extra": _finite(self.extra),
            "distance": _finite(self.distance),
            "seconds": _finite(self.seconds),
            "load": float(self.load),
            "items": list(self.items),
            "is_shortest": self.is_shortest,
        }


def rank_orders(
    instance: Instance,
    at: Place | str | None = None,
    robot: str | None = None,
    *,
    stop: Stop | None = None,
) -> tuple[RankedOrder, ...]:
    """Rank the waiting orders by what each costs a robot from where it stands.

    Parameters
    ----------
    instance
        Its orders are those that wait.
    at
        Where the robot stands: a place of the warehouse, or text: ``depot``, the id of an item
        that lies there or the label of its bin, or numbers (``AISLE,SLOT`` or
        ``AISLE,SLOT,BLOCK`` from 0, ``X,Y``, or the node of a table); the depot by default.
    robot
        Id of the robot, whose capacity and speed count; the first one by default.
    stop
        When to leave off proving; after `DEFAULT_SECONDS` by default.

    Returns
    -------
    tuple
        The orders that the robot can carry: the least extra way first, equals in the sequence of
        the instance. Up to 12 stops of an order the way is always a shortest one.

    Raises
    ------
    InputError
        When the place or the robot does not exist.
    InfeasibleError
        When every order is heavier than the robot's capacity.
    """
    who = _robot(instance, robot)
    place = _place(instance, at)
    stop = Stop(DEFAULT_SECONDS) if stop is None else stop
    d = instance.place_distances
    rows, start = instance.place_of_node, 0
    if place is not None:
        d = instance.warehouse.distance_matrix((place, *instance.places))
        rows, start = np.where(rows > 0, rows + 1, 0), 1
    stops: list[list[Sequence[int]]] = [[] for _ in instance.orders]
    for nodes in instance.stops:
        stops[int(instance.order_of_node[nodes[0]])].append(nodes)
    weights = [sum((instance.items[v - 1].weight for v in nodes), Fraction(0))
               for nodes in instance.order_nodes]  # fmt: skip
    if instance.orders and min(weights) > who.capacity:
        raise InfeasibleError(
            f"every order is heavier than {float(who.capacity):g}, which robot {who.id} carries"
        )
    home = float(d[start, 0])
    ranked = []
    for order, own, load in zip(instance.orders, stops, weights, strict=True):
        if load > who.capacity:
            continue
        at_rows = [int(rows[nodes[0]]) for nodes in own]
        # One node stands for both ends: ways leave it from the robot and enter it at the depot.
        ways = d[np.ix_([start, *at_rows], [0, *at_rows])]
        tour, proven = best_sequence(ways, stop)
        length = tour_length(ways, tour)
        items = [instance.items[v - 1] for s in tour for v in own[s - 1]]
        ranked.append(
            RankedOrder(
                order=order.id,
                extra=round(length - home, DIGITS) if math.isfinite(home) else length,
                distance=length,
                seconds=instance.times.per_trip
                + length / who.speed
                + math.fsum(map(instance.times.of, items)),
                load=load,
                items=tuple(item.id for item in items),
                is_shortest=proven,
            )
        )
    return tuple(sorted(ranked, key=lambda one: round(one.distance, DIGITS)))


def _robot(instance: Instance, name: str | None) -> Robot:
    known = {robot.id: robot for robot in instance.robots}
    if name is None:
        return instance.robots[0]
    if name not in known:
        raise InputError(
            f"{name!r} is not a robot here",
            field="robot",
            advice=f"use one of: {', '.join(list(known)[:10])}",
        )
    return known[name]


def _place(instance: Instance, at: Place | str | None) -> Place | None:
    """Return the place that is meant, None for the depot."""
    if at is None or at == "depot":
        return None
    place = _named(instance, at) if isinstance(at, str) else at
    try:
        instance.warehouse.check(place)
    except InputError as error:
        raise error.at("at") from None
    return place


def _named(instance: Instance, text: str) -> Place:
    """Return the place that a text means."""
    labels = {item.label: item for item in instance.items if item.label}
    items = labels | {item.id: item for item in instance.items}  # an id comes first
    if text in items:
        return items[text].place
    if text in dict(getattr(instance.warehouse, "poses", ())):
        return Pose(text)
    form = FORMS.get(instance.warehouse.kind, "coordinates as X,Y")
    try:
        match instance.warehouse.kind:
            case "aisles":
                aisle, slot, *block = map(int, text.split(","))
                (within,) = block or [0]
                return Slot(aisle, slot, within)
            case "matrix":
                return Node(int(text))
            case _:
                x, y = map(float, text.split(","))
                return Point(x, y)
    except ValueError:
        meant = near(text, items)
        label = ", the label of its bin" if labels else ""
        raise InputError(
            f"{text!r} is not a place here",
            field="at",
            advice=f"{meant} give depot, the id of an item{label}, or {form}".lstrip(),
        ) from None


def _finite(value: float) -> float | None:
    """Return a number as JSON has it."""
    return value if math.isfinite(value) else None
