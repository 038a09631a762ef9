"""Pick lists: what to take at each stop of a trip, and the basket that it goes into."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from qrobot._csv import csv_text
from qrobot._files import StrPath
from qrobot._json import json_text
from qrobot._numbers import number
from qrobot._text import columns, count, printable
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import Instance, Item, Node, Point, Pose, Slot
from qrobot.problem.checks import canonical
from qrobot.report.scene import Journey, Scene, checked_scene
from qrobot.report.timeline import timeline

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = [
    "PICKLIST_SCHEMA",
    "Basket",
    "Pick",
    "PickList",
    "PickLists",
    "exact_text",
    "location",
    "pick_lists",
]

PICKLIST_SCHEMA = "qrobot.picklist/1"

COLUMNS = (
    "trip", "robot", "stop", "location", "article", "quantity", "basket", "order", "load", "item",
    "weight", "distance", "seconds",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Pick:
    """One line of a pick list.

    Parameters
    ----------
    stop
        Which stop of the trip, from 1.
    item
        What is taken.
    location
        Where it lies, in words.
    order
        Id of the order that it is for.
    basket
        Number of that order's basket on the trolley, from 1.
    load
        Weight of all that is carried after it, exact.
    distance, seconds
        Way and time since the robot left the depot; the time when it is collected.
    """

    stop: int
    item: Item
    location: str
    order: str
    basket: int
    load: Fraction
    distance: float
    seconds: float

    @property
    def article(self) -> str:
        """What is written on the thing."""
        return self.item.article or self.item.id


@dataclass(frozen=True, slots=True)
class Basket:
    """A basket on the trolley: one order's.

    Parameters
    ----------
    number
        From 1, in the sequence in which the trip first needs them.
    order
        Id of the order.
    quantity, load
        Pieces and weight in it at the end.
    """

    number: int
    order: str
    quantity: int
    load: Fraction


@dataclass(frozen=True, slots=True)
class PickList:
    """What one robot takes on one trip, in sequence.

    Parameters
    ----------
    journey
        The trip, with its number in the plan and its way.
    picks
        Its lines.
    baskets
        One for each order.
    turn, turns
        Which trip of the robot it is, from 1, and how many the robot makes.
    seconds
        From the depot and back to it, driving and collecting.
    """

    journey: Journey
    picks: tuple[Pick, ...]
    baskets: tuple[Basket, ...]
    turn: int
    turns: int
    seconds: float

    @property
    def robot(self) -> str:
        """Id of the robot."""
        return self.journey.trip.robot

    @property
    def distance(self) -> float:
        """Length of the way, with both legs to the depot."""
        return self.journey.trip.distance

    @property
    def load(self) -> Fraction:
        """Weight at the end."""
        return self.picks[-1].load


@dataclass(frozen=True, slots=True)
class PickLists:
    """The pick lists of a plan, a list a trip.

    Parameters
    ----------
    scene
        The plan in its warehouse.
    lists
        By robot, as the trips of the plan.
    robots
        Ids of the robots that they are for; those without a trip stay home.
    """

    scene: Scene
    lists: tuple[PickList, ...]
    robots: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the lists as plain data (schema ``qrobot.picklist/1``)."""
        return {
            "schema": PICKLIST_SCHEMA,
            "instance": self.scene.instance.name,
            "trips": [_trip_data(one) for one in self.lists],
        }

    def to_json(self) -> str:
        """Return the lists as JSON text."""
        return json_text(self.to_dict(), indent=1, ensure_ascii=False) + "\n"

    def to_csv(self) -> str:
        """Return a line a pick as CSV; no name becomes a formula of a spreadsheet."""
        rows = [
            {
                "trip": one.journey.number,
                "robot": one.robot,
                "stop": pick.stop,
                "location": pick.location,
                "article": pick.article,
                "quantity": pick.item.quantity,
                "basket": pick.basket,
                "order": pick.order,
                "load": exact_text(pick.load),
                "item": pick.item.id,
                "weight": exact_text(pick.item.weight),
                "distance": f"{pick.distance:.12g}",
                "seconds": f"{pick.seconds:.12g}",
            }
            for one in self.lists
            for pick in one.picks
        ]
        return csv_text(rows, COLUMNS)

    def to_text(self) -> str:
        """Return the lists as tables for a terminal."""
        heads = ["stop", "location", "article", "quantity", "basket", "load"]
        parts = []
        for one in self.lists:
            rows = [
                [
                    str(pick.stop),
                    pick.location,
                    printable(pick.article),
                    str(pick.item.quantity),
                    f"{pick.basket}: {printable(pick.order)}",
                    exact_text(pick.load),
                ]
                for pick in one.picks
            ]
            capacity = exact_text(one.journey.capacity)
            parts.append(
                f"{printable(one.robot)}, trip {one.turn} of {one.turns}: "
                f"{count(len(one.picks), 'pick')}, {count(len(one.baskets), 'basket')}, load "
                f"{exact_text(one.load)} of {capacity}, distance {number(one.distance)}, "
                f"{number(one.seconds)} s\n" + columns(heads, rows, numbers=frozenset({0, 3, 5}))
            )
        return "\n\n".join(parts or ["no trips"]) + "\n"


def pick_lists(
    answer: Result | Plan | StrPath,
    instance: Instance | StrPath | None = None,
    robots: Sequence[str] = (),
) -> PickLists:
    """Return the pick lists of a plan.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    instance
        The question; needed for a plan alone.
    robots
        Ids of the robots whose lists are wanted; empty: of all.

    Raises
    ------
    InputError
        When the plan is not right for the instance, as `qrobot.check` says, or a robot is not
        in it.

    Examples
    --------
    >>> import qrobot
    >>> instance = qrobot.read("examples/paper-7-items.json")
    >>> lists = pick_lists(qrobot.solve(instance), robots=["R2"])
    >>> [(pick.article, pick.basket, float(pick.load)) for pick in lists.lists[0].picks]
    [('6', 1, 4.0), ('7', 2, 6.0), ('1', 3, 14.0)]
    """
    scene = checked_scene(answer, instance)
    fleet = [robot.id for robot in scene.instance.robots]
    wanted = tuple(map(canonical, robots)) or tuple(fleet)
    for name in wanted:
        if name not in fleet:
            known = ", ".join(fleet[:8]) + (", .." if len(fleet) > 8 else "")
            raise InputError(f"{name!r} is not a robot here", advice=f"use one of: {known}")
    owner = {item: order.id for order in scene.instance.orders for item in order.items}
    turns = Counter(journey.robot.id for journey in scene.journeys)
    lists = []
    for journey in scene.journeys:
        robot = journey.robot.id
        if robot in wanted:
            lists.append(_pick_list(scene.instance, journey, owner, turns[robot]))
    return PickLists(scene, tuple(lists), tuple(dict.fromkeys(wanted)))


def _pick_list(
    instance: Instance,
    journey: Journey,
    owner: dict[str, str],
    turns: int,
) -> PickList:
    *stops, end = timeline(journey, instance.times)
    numbers: dict[str, int] = {}
    picks, load = [], Fraction(0)
    for stop, (item, visit) in enumerate(zip(journey.items, stops, strict=True), 1):
        order = owner[item.id]
        basket = numbers.setdefault(order, len(numbers) + 1)
        load += item.weight
        picks.append(
            Pick(
                stop, item, location(instance, item), order, basket, load,
                visit.distance, visit.leaves,
            )
        )  # fmt: skip
    baskets = tuple(
        Basket(
            basket,
            order,
            sum(pick.item.quantity for pick in picks if pick.basket == basket),
            sum((pick.item.weight for pick in picks if pick.basket == basket), Fraction(0)),
        )
        for order, basket in numbers.items()
    )
    return PickList(journey, tuple(picks), baskets, journey.turn + 1, turns, end.leaves)


def location(instance: Instance, item: Item) -> str:
    """Return where an item lies: the label of its bin, or else the place in words."""
    if item.label:
        return item.label
    match place := item.place:
        case Slot():
            several = getattr(instance.warehouse, "blocks", 1) > 1
            block = f"block {place.block}, " if several else ""
            return f"aisle {place.aisle}, {block}slot {place.slot}, {place.side}"
        case Point():
            return f"x {number(place.x)}, y {number(place.y)}"
        case Node():
            return f"node {place.index}"
        case Pose():
            return place.name


def exact_text(value: Fraction) -> str:
    """Return a weight with all its digits."""
    return f"{float(value):.12g}"


def _trip_data(one: PickList) -> dict[str, Any]:
    return {
        "trip": one.journey.number,
        "robot": one.robot,
        "turn": one.turn,
        "turns": one.turns,
        "load": float(one.load),
        "capacity": float(one.journey.capacity),
        "distance": one.distance,
        "seconds": one.seconds,
        "baskets": [
            {"basket": b.number, "order": b.order, "quantity": b.quantity, "load": float(b.load)}
            for b in one.baskets
        ],
        "picks": [
            {
                "stop": pick.stop,
                "location": pick.location,
                "article": pick.article,
                "quantity": pick.item.quantity,
                "basket": pick.basket,
                "order": pick.order,
                "load": float(pick.load),
                "item": pick.item.id,
                "weight": float(pick.item.weight),
                "distance": pick.distance,
                "seconds": pick.seconds,
            }
            for pick in one.picks
        ],
    }
