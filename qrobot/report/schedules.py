"""When each robot is where: its trips one after the other, for people, programs and a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from qrobot._csv import csv_text
from qrobot._json import json_text
from qrobot._numbers import number
from qrobot._text import columns, printable
from qrobot.report.picklist import location
from qrobot.report.reservations import Inside
from qrobot.report.scene import Journey, Scene
from qrobot.report.timeline import Visit

__all__ = [
    "SCHEDULE_SCHEMA",
    "OrderEnd",
    "RobotSchedule",
    "Schedule",
    "TimedTrip",
]

SCHEDULE_SCHEMA = "qrobot.schedule/1"

COLUMNS = (
    "robot", "turn", "trip", "stop", "location", "item", "order", "distance", "arrives", "leaves",
)  # fmt: skip

MOST_NAMES = 8
"""Robots that are named when they stay home, and orders that are late."""

ON_TIME = 1e-6
"""Seconds after a due time that are rounding."""


@dataclass(frozen=True, slots=True)
class TimedTrip:
    """A trip and when it is made.

    Parameters
    ----------
    journey
        The trip, with its number in the plan.
    begins
        When its set-up begins, seconds since all robots began.
    leaves
        When the robot leaves the depot.
    visits
        Its stops and its end, in seconds since its set-up began.
    waits
        When it waits for other robots: from and to, seconds since all robots began.
    inside
        Its stays in sub-aisles, where these are reserved.
    """

    journey: Journey
    begins: float
    leaves: float
    visits: tuple[Visit, ...]
    waits: tuple[tuple[float, float], ...] = ()
    inside: tuple[Inside, ...] = ()

    @property
    def ends(self) -> float:
        """When the robot is back, seconds since all robots began."""
        return self.begins + self.visits[-1].leaves

    @property
    def collecting(self) -> float:
        """Seconds that the robot stands at its stops."""
        return sum(visit.leaves - visit.arrives for visit in self.visits)

    @property
    def waiting(self) -> float:
        """Seconds that it waits for other robots."""
        return sum(until - since for since, until in self.waits)

    @property
    def driving(self) -> float:
        """Seconds that the robot drives."""
        return self.ends - self.leaves - self.collecting - self.waiting


@dataclass(frozen=True, slots=True)
class RobotSchedule:
    """All trips of a robot, one after the other.

    Parameters
    ----------
    robot
        Its id.
    trips
        In sequence; none for a robot that stays home.
    """

    robot: str
    trips: tuple[TimedTrip, ...]

    @property
    def ends(self) -> float:
        """When it is back for the last time, seconds since all robots began."""
        return self.trips[-1].ends if self.trips else 0.0

    @property
    def collecting(self) -> float:
        """Seconds that it stands at stops."""
        return sum(trip.collecting for trip in self.trips)

    @property
    def driving(self) -> float:
        """Seconds that it drives."""
        return sum(trip.driving for trip in self.trips)

    @property
    def working(self) -> float:
        """Seconds of all its trips with their set-ups, without waiting."""
        return sum(trip.ends - trip.begins - trip.waiting for trip in self.trips)


@dataclass(frozen=True, slots=True)
class OrderEnd:
    """When an order is back.

    Parameters
    ----------
    order
        Its id.
    back
        When its trip is back, seconds since all robots began.
    due
        When it should be, ``inf`` for no matter when.
    deadline
        When it must be.
    """

    order: str
    back: float
    due: float
    deadline: float

    @property
    def late(self) -> float:
        """Seconds after its due time."""
        return max(0.0, self.back - self.due)


@dataclass(frozen=True, slots=True)
class Schedule:
    """Who is where, and when: all robots begin at once, each makes its trips as early as it may.

    Parameters
    ----------
    scene
        The plan in its warehouse.
    robots
        In the sequence of the instance.
    per_aisle
        How many robots may be in a sub-aisle at once; ``None``: any number.
    undisturbed
        When the last robot would be back if none waited for another, seconds.
    """

    scene: Scene
    robots: tuple[RobotSchedule, ...]
    per_aisle: int | None = None
    undisturbed: float = 0.0

    @property
    def ends(self) -> float:
        """When the last robot is back (the makespan), seconds."""
        return max((own.ends for own in self.robots), default=0.0)

    @property
    def orders(self) -> list[OrderEnd]:
        """When each order is back, in the sequence of the instance; split ones with their last."""
        back: dict[str, float] = {}
        for own in self.robots:
            for trip in own.trips:
                for order in trip.journey.trip.orders:
                    back[order] = max(trip.ends, back.get(order, 0.0))
        return [
            OrderEnd(order.id, back[order.id], order.due, order.deadline)
            for order in self.scene.instance.orders
            if order.id in back
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the schedule as plain data (schema ``qrobot.schedule/1``)."""
        return {
            "schema": SCHEDULE_SCHEMA,
            "instance": self.scene.instance.name,
            "ends": self.ends,
            "per_aisle": self.per_aisle,
            "undisturbed": self.undisturbed,
            "robots": [
                {
                    "robot": own.robot,
                    "ends": own.ends,
                    "driving": own.driving,
                    "collecting": own.collecting,
                    "trips": [self._trip_data(trip) for trip in own.trips],
                }
                for own in self.robots
            ],
            "orders": [
                {
                    "order": one.order,
                    "back": one.back,
                    "due": one.due if math.isfinite(one.due) else None,
                    "late": one.late,
                }
                for one in self.orders
            ],
        }

    def _trip_data(self, trip: TimedTrip) -> dict[str, Any]:
        return {
            "trip": trip.journey.number,
            "begins": trip.begins,
            "leaves": trip.leaves,
            "waiting": trip.waiting,
            "ends": trip.ends,
            "distance": trip.journey.trip.distance,
            "stops": [
                {
                    "item": item.id,
                    "location": location(self.scene.instance, item),
                    "arrives": trip.begins + visit.arrives,
                    "leaves": trip.begins + visit.leaves,
                }
                for item, visit in zip(trip.journey.items, trip.visits, strict=False)
            ],
        }

    def to_json(self) -> str:
        """Return the schedule as JSON text."""
        return json_text(self.to_dict(), indent=1, ensure_ascii=False) + "\n"

    def to_csv(self) -> str:
        """Return a line a stop as CSV, and one for each return to the depot."""
        owner = {item: order.id for order in self.scene.instance.orders for item in order.items}
        rows = []
        for own in self.robots:
            for turn, trip in enumerate(own.trips, 1):
                for stop, visit in enumerate(trip.visits, 1):
                    last = stop == len(trip.visits)
                    item = None if last else trip.journey.items[stop - 1]
                    rows.append(
                        {
                            "robot": own.robot,
                            "turn": turn,
                            "trip": trip.journey.number,
                            "stop": stop,
                            "location": "depot"
                            if item is None
                            else location(self.scene.instance, item),
                            "item": "" if item is None else item.id,
                            "order": "" if item is None else owner[item.id],
                            "distance": f"{visit.distance:.12g}",
                            "arrives": f"{trip.begins + visit.arrives:.12g}",
                            "leaves": f"{trip.begins + visit.leaves:.12g}",
                        }
                    )
        return csv_text(rows, COLUMNS)

    def to_text(self) -> str:
        """Return a line a trip as a table for a terminal, and when all are back."""
        rows = [
            [
                printable(own.robot),
                f"{turn} of {len(own.trips)}",
                *(
                    f"{number(value)} s"
                    for value in (trip.leaves, trip.ends, trip.driving, trip.collecting)
                ),
                number(trip.journey.trip.distance),
                str(len(trip.journey.items)),
            ]
            for own in self.robots
            for turn, trip in enumerate(own.trips, 1)
        ]
        heads = ["robot", "trip", "leaves", "back", "driving", "collecting", "distance", "picks"]
        last = max(self.robots, key=lambda own: own.ends, default=None)
        if last is None or not last.trips:
            return "no trips\n"
        home = [printable(own.robot) for own in self.robots if not own.trips]
        table = columns(heads, rows, numbers=frozenset(range(2, len(heads))))
        some = ", ".join(home[:MOST_NAMES]) + (", .." if len(home) > MOST_NAMES else "")
        idle = f"\nwithout a trip: {some}" if home else ""
        back = f"all robots are back after {number(self.ends)} s, {printable(last.robot)} last"
        total = sum(own.working for own in self.robots)
        rest = f"together they work {number(total)} s\n"
        return f"{table}{idle}\n{back}; {rest}{self._waits()}{self._late()}"

    def _waits(self) -> str:
        """Return a line about waiting, where sub-aisles are reserved."""
        if self.per_aisle is None:
            return ""
        waited = sum(trip.waiting for own in self.robots for trip in own.trips)
        added = max(0.0, round(self.ends - self.undisturbed, 6))
        share = f" ({added / self.undisturbed:.1%})" if self.undisturbed else ""
        return (
            f"at most {self.per_aisle} at a time in each sub-aisle: robots wait "
            f"{number(waited)} s, the last is back {number(added)} s later{share}\n"
        )

    def _late(self) -> str:
        """Return a line about due times and one about deadlines, where there are any."""
        lines = ""
        for what in ("due time", "deadline"):
            times = {one.order: getattr(one, what.split()[0]) for one in self.orders}
            asked = [one for one in self.orders if math.isfinite(times[one.order])]
            after = {one.order: one.back - times[one.order] for one in asked}
            late = sorted((o for o in after if after[o] > ON_TIME), key=lambda o: -after[o])
            some = ", ".join(f"{printable(o)} by {number(after[o])} s" for o in late[:MOST_NAMES])
            rest = ", .." if len(late) > MOST_NAMES else ""
            if late:
                lines += (
                    f"{len(late)} of {len(asked)} orders with a {what} are late: {some}{rest}\n"
                )
            elif asked:
                lines += f"all {len(asked)} orders with a {what} are back in time\n"
        return lines
