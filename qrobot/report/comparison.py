"""The trips of a plan walked by every routing policy: lengths beside the shortest, and pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from qrobot._files import StrPath, write_text_atomic
from qrobot._numbers import number
from qrobot._text import columns
from qrobot.errors import InputError
from qrobot.pages import render
from qrobot.plan import Plan, check, plan_of
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.report.floorplan import floor_plan
from qrobot.report.fonts import font_notes
from qrobot.report.picture import check_picture_path, save, style
from qrobot.report.scene import Journey, Scene, scene_of
from qrobot.warehouse import POLICIES, route

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["COMPARISON_SCHEMA", "PolicyComparison", "PolicyWays", "compare_routing"]

COMPARISON_SCHEMA = "qrobot.compare-routing/1"
HERE = Path(__file__).parent
DRAWING = 460.0, 360.0


@dataclass(frozen=True, slots=True)
class PolicyWays:
    """The ways of all trips by one policy.

    Parameters
    ----------
    policy
        Its name.
    distance
        Of all trips, metres; ``nan`` where the policy says nothing about the layout.
    trips
        The distance of each.
    problem
        Why there are no ways; empty where there are.
    scene
        The ways to be drawn, with the stops in the sequence of the policy.
    """

    policy: str
    distance: float
    trips: tuple[float, ...]
    problem: str
    scene: Scene | None


@dataclass(frozen=True, slots=True)
class PolicyComparison:
    """A plan's trips by every policy.

    Parameters
    ----------
    scene
        The plan itself.
    distance
        Of the plan.
    ways
        One of each policy, the shortest tours first.
    """

    scene: Scene
    distance: float
    ways: tuple[PolicyWays, ...]

    def against_shortest(self, distance: float) -> float:
        """Return how much longer than the shortest tours a distance is: 0.1 is a tenth."""
        shortest = self.ways[0].distance
        return distance / shortest - 1 if shortest > 0 else math.nan

    def to_text(self) -> str:
        """Return an aligned table."""
        rows = [
            (
                name,
                f"{number(distance)}{self.scene.unit}",
                _percent(self.against_shortest(distance)),
            )
            for name, distance in [
                ("the plan", self.distance),
                *((w.policy, w.distance) for w in self.ways if not w.problem),
            ]
        ]
        table = columns(["policy", "distance", "against the shortest"], rows, frozenset({1, 2}))
        return "\n".join([table, *(w.problem for w in self.ways if w.problem)])

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as plain data (schema ``qrobot.compare-routing/1``)."""
        return {
            "schema": COMPARISON_SCHEMA,
            "instance": self.scene.instance.name,
            "plan_distance": self.distance,
            "policies": [
                {
                    "policy": w.policy,
                    "distance": None if w.problem else w.distance,
                    "against_shortest": _finite(self.against_shortest(w.distance)),
                    "problem": w.problem or None,
                    "trips": [
                        {"robot": j.trip.robot, "distance": length, "stops": list(j.trip.stops)}
                        for j, length in _trips(w)
                    ],
                }
                for w in self.ways
            ],
        }

    def draw(self, path: StrPath) -> tuple[str, ...]:
        """Write a picture, ``.svg``, ``.png`` or ``.html``, with a panel for each policy.

        Returns
        -------
        tuple of str
            What a person should know of the picture, a sentence each.
        """
        kind = check_picture_path(path, animated=True)
        panels = [(self._title(w), w.scene) for w in self.ways if w.scene is not None]
        title = f"Routing policies on {self.scene.instance.name}"
        if kind == "html":
            maps = [(text, floor_plan(scene, scene.journeys, DRAWING)) for text, scene in panels]
            problems = [w.problem for w in self.ways if w.problem]
            page = render(
                HERE / "comparison.html",
                title=title,
                subtitle=self.scene.subtitle,
                panels=maps,
                problems=problems,
            )
            write_text_atomic(path, page)
            return ()
        texts = self.scene.texts()
        with style(texts) as missing:
            from qrobot.report.draw_aisles import draw_panels

            save(draw_panels(title, panels), path)
            return tuple(font_notes(missing, texts)) if kind == "png" else ()

    def _title(self, ways: PolicyWays) -> str:
        more = _percent(self.against_shortest(ways.distance))
        return f"{ways.policy}: {number(ways.distance)}{self.scene.unit} ({more})"


def compare_routing(
    answer: Result | Plan | StrPath,
    instance: Instance | StrPath | None = None,
    sort_index: Mapping[Slot, float] | None = None,
) -> PolicyComparison:
    """Walk the trips of a plan by every routing policy.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    instance
        The question; needed for a plan alone.
    sort_index
        In which sequence the policy ``as-given`` visits locations: those with the lower number
        first. By default aisle, then block, then slot.

    Raises
    ------
    InputError
        When the warehouse has no aisles, or the plan is not right for the instance.

    Examples
    --------
    >>> import qrobot
    >>> instance = qrobot.read("examples/small-warehouse.json")
    >>> comparison = compare_routing(qrobot.solve(instance, deadline=1))
    >>> [ways.policy for ways in comparison.ways if ways.problem]
    ['return', 'midpoint']
    """
    scene, plan = scene_of(answer, instance), plan_of(answer)
    house = scene.instance.warehouse
    if not isinstance(house, AisleWarehouse):
        raise InputError("routing policies are rules for aisles, this warehouse has none")
    report = check(plan, scene.instance)
    if not report.ok:
        raise InputError(
            f"the plan is not right for this instance: {report.problems[0]}",
            advice="`qrobot check` lists all that is wrong",
        )
    ways = tuple(_ways(policy, scene, house, sort_index) for policy in POLICIES)
    return PolicyComparison(scene, report.distance, ways)


def _ways(
    policy: str, scene: Scene, house: AisleWarehouse, sort_index: Mapping[Slot, float] | None
) -> PolicyWays:
    journeys = []
    for journey in scene.journeys:
        items = list(journey.items)
        if policy == "as-given":
            items.sort(key=lambda item: _rank(item.place, sort_index))
        try:
            way = route(
                house, [item.place for item in items if isinstance(item.place, Slot)], policy
            )
        except InputError as error:
            return PolicyWays(policy, math.nan, (), str(error).removeprefix("policy: "), None)
        picked = tuple(items[i] for i in way.sequence)
        stops = tuple(item.id for item in picked)
        trip = replace(journey.trip, stops=stops, distance=way.length)
        journeys.append(replace(journey, trip=trip, items=picked, legs=way.legs))
    lengths = tuple(journey.trip.distance for journey in journeys)
    shown = replace(scene, journeys=tuple(journeys))
    return PolicyWays(policy, math.fsum(lengths), lengths, "", shown)


def _trips(ways: PolicyWays) -> list[tuple[Journey, float]]:
    return list(zip(ways.scene.journeys if ways.scene else (), ways.trips, strict=True))


def _rank(place: object, sort_index: Mapping[Slot, float] | None) -> tuple[float, ...]:
    assert isinstance(place, Slot)
    own = (place.aisle, place.block, place.slot)
    return own if sort_index is None else (sort_index.get(place, math.inf), *own)


def _percent(share: float) -> str:
    return f"{100 * share:+.1f} %" if math.isfinite(share) else "-"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
