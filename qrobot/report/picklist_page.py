"""The page of pick lists: printed, each trip begins on a new sheet, with its way on the map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from qrobot._numbers import number
from qrobot._text import count
from qrobot.errors import InputError
from qrobot.pages import render
from qrobot.report.floorplan import floor_plan
from qrobot.report.picklist import PickList, PickLists, exact_text
from qrobot.report.scene import Scene

__all__ = ["PAPERS", "picklist_page"]

HERE = Path(__file__).parent
HEADS = ("stop", "location", "article", "quantity", "basket", "load")


@dataclass(frozen=True, slots=True)
class Paper:
    """What a page is printed on.

    Parameters
    ----------
    title
        For people.
    size, margin, font, map
        Of the sheet, around it, of the text, and the height of the map at most, as CSS.
    drawing
        Width and height of the map in its own units at most: the fewer, the larger its letters.
    """

    title: str
    size: str
    margin: str
    font: str
    map: str
    drawing: tuple[float, float]


PAPERS = {
    "a4": Paper("A4", "210mm 297mm", "12mm", "10.5pt", "88mm", (760.0, 560.0)),
    "a5": Paper("A5", "148mm 210mm", "8mm", "8.5pt", "56mm", (600.0, 440.0)),
    "label": Paper("labels of 100 x 150 mm", "100mm 150mm", "4mm", "7.5pt", "42mm", (420.0, 300.0)),
}


def picklist_page(lists: PickLists, paper: str = "a4") -> str:
    """Return the lists as a page that needs nothing but itself.

    Parameters
    ----------
    lists
        Of `pick_lists`.
    paper
        What it is printed on: ``a4``, ``a5`` or ``label`` (100 x 150 mm).

    Raises
    ------
    InputError
        When the paper is another one.
    """
    if paper not in PAPERS:
        raise InputError(
            f"{paper!r} is not a paper", field="paper", advice=f"use one of: {', '.join(PAPERS)}"
        )
    busy = {one.robot for one in lists.lists}
    picks = sum(len(one.picks) for one in lists.lists)
    return render(
        HERE / "picklist.html",
        name=lists.scene.instance.name,
        summary=f"{count(len(lists.lists), 'trip')}, {count(picks, 'pick')}",
        paper=PAPERS[paper],
        heads=HEADS,
        numbers=("quantity", "load"),
        home=[robot for robot in lists.robots if robot not in busy],
        sheets=[_sheet(lists.scene, one, PAPERS[paper]) for one in lists.lists],
    )


def _sheet(scene: Scene, one: PickList, paper: Paper) -> dict[str, object]:
    trip = f", trip {one.turn} of {one.turns}" if one.turns > 1 else ""
    capacity = exact_text(one.journey.capacity)
    return {
        "number": one.journey.number,
        "title": f"{one.robot}{trip}",
        "colour": one.journey.colour,
        "line": f"{count(len(one.picks), 'pick')} into {count(len(one.baskets), 'basket')}, load "
        f"{exact_text(one.load)} of {capacity}, way {scene.length(one.distance)}, "
        f"{number(one.seconds)} s",
        "baskets": one.baskets,
        "map": floor_plan(scene, [one.journey], paper.drawing),
        "rows": [
            (
                str(pick.stop),
                pick.location,
                pick.article,
                str(pick.item.quantity),
                str(pick.basket),
                exact_text(pick.load),
            )
            for pick in one.picks
        ],
    }
