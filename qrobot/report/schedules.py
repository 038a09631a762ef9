"""When each robot is where: its trips one after the other, for people, programs and a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from qrobot._csv import csv_text
from qrobot._files import StrPath
from qrobot._json import json_text
from qrobot._numbers import number
from qrobot._text import columns, printable
from qrobot.plan import Plan
from qrobot.problem import Instance
from qrobot.report.picklist import location
from qrobot.report.scene import Journey, Scene, checked_scene
from qrobot.report.timeline import Visit, timeline

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["SCHEDULE_SCHEMA", "RobotSchedule", "Schedule", "TimedTrip", "schedule", "schedule_of"]

SCHEDULE_SCHEMA = "qrobot.schedule/1"

COLUMNS = (
    "robot", "turn", "trip", "stop", "location", "item", "order", "distance", "arrives", "leaves",
)  # fmt: skip

MOST_NAMES = 8
"""Robots that are named when they stay home."""


@dataclass(frozen=True, slots=True)
class TimedTrip:
    """A trip and when it is made.

    Parameters
    ----------
    journey
        The trip, with its number in the plan.
    begins
        When the robot leaves the depot, seconds since all robots began.
    visits
        Its stops and its end, in seconds since it left the depot.
    """

    journey: Journey
    begins: float
    visits: tuple[Visit, ...]

    @property
    def ends(self) -> float:
        """When the robot is back, seconds since all robots began."""
        return self.begins + self.visits[-1].leaves

    @property
    def collecting(self) -> float:
        """Seconds that the robot stands at its stops."""
        return sum(visit.leaves - visit.arrives for visit in self.visits)

    @property
    def driving(self) -> float:
        """Seconds that the robot drives."""
        return self.visits[-1].leaves - self.collecting


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
        return self.ends - self.collecting


@dataclass(frozen=True, slots=True)
class Schedule:
    """Who is where, and when: all robots begin at once, each makes its trips without a break.

    Parameters
    ----------
    scene
        The plan in its warehouse.
    robots
        In the sequence of the instance.
    """

    scene: Scene
    robots: tuple[RobotSchedule, ...]

    @property
    def ends(self) -> float:
        """When the last robot is back (the makespan), seconds."""
        return max((own.ends for own in self.robots), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the schedule as plain data (schema ``qrobot.schedule/1``)."""
        return {
            "schema": SCHEDULE_SCHEMA,
            "instance": self.scene.instance.name,
            "ends": self.ends,
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
        }

    def _trip_data(self, trip: TimedTrip) -> dict[str, Any]:
        return {
            "trip": trip.journey.number,
            "begins": trip.begins,
            "ends": trip.ends,
            "distance": trip.journey.trip.distance,
            "stops": [
                {
                    "item": item.id,
                    "location": location(self.scene.instance, item.place),
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
                            else location(self.scene.instance, item.place),
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
                    for value in (trip.begins, trip.ends, trip.driving, trip.collecting)
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
        total = sum(own.ends for own in self.robots)
        return f"{table}{idle}\n{back}; together they work {number(total)} s\n"


def schedule(
    answer: Result | Plan | StrPath, instance: Instance | StrPath | None = None
) -> Schedule:
    """Return when each robot is where.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    instance
        The question; needed for a plan alone.

    Raises
    ------
    InputError
        When the plan is not right for the instance, as `qrobot.check` says.

    Examples
    --------
    >>> import qrobot
    >>> found = schedule(qrobot.solve("examples/paper-7-items.json"))
    >>> [(own.robot, len(own.trips)) for own in found.robots]
    [('R1', 1), ('R2', 1), ('R3', 1)]
    >>> found.ends == max(trip.ends for own in found.robots for trip in own.trips)
    True
    """
    return schedule_of(checked_scene(answer, instance))


def schedule_of(scene: Scene) -> Schedule:
    """Return when each robot of a plan is where, its trips in the sequence of the plan."""
    trips: dict[str, list[TimedTrip]] = {robot.id: [] for robot in scene.instance.robots}
    for journey in scene.journeys:
        before = trips[journey.robot.id]
        begins = before[-1].ends if before else 0.0
        before.append(TimedTrip(journey, begins, tuple(timeline(journey))))
    return Schedule(scene, tuple(RobotSchedule(name, tuple(own)) for name, own in trips.items()))
