"""What Python and notebooks show of the answer: one line, and a table that no name can break."""

from __future__ import annotations

import html.parser
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest
from oracles import paper_shaped

import qrobot
from qrobot._notebook import MOST_ROWS, html_table
from qrobot._numbers import number
from qrobot.models import build_model
from qrobot.problem import DistanceTable

EVIL = '<script>alert("1")</script>&<b>'


def evil() -> qrobot.Instance:
    """An instance whose names are markup; its own name is of many lines, and not even text."""
    one = paper_shaped(4, 2, 0)
    names = {item.id: f"{item.id}{EVIL}" for item in one.items}
    return replace(
        one,
        name=f"{EVIL}\n\ud800" * 20,
        items=tuple(replace(item, id=names[item.id]) for item in one.items),
        orders=tuple(
            replace(order, items=tuple(names[i] for i in order.items)) for order in one.orders
        ),
        robots=tuple(replace(robot, id=f"{robot.id}{EVIL}") for robot in one.robots),
    )


def shown() -> list[object]:
    result = qrobot.solve(evil(), backend="exact")
    sampled = qrobot.solve(paper_shaped(4, 2, 0), backend="neal", num_reads=5)
    ways = DistanceTable(matrix=((0.0,) * 200,) * 200)
    model = build_model(evil())
    return [
        result, result.plan, result.plan.trips[0], result.instance, sampled, sampled.sampler, model,
        ways, ways.matrix and qrobot.check(result, result.instance),
    ]  # fmt: skip


def test_every_repr_is_one_short_line() -> None:
    for one in shown():
        for text in (repr(one), str(one)):
            assert "\n" not in text
            assert 0 < len(text) < 250
            text.encode("utf-8")


def test_reprs_say_what_matters() -> None:
    result = qrobot.solve(paper_shaped(4, 2, 0), backend="exact")
    assert repr(result).startswith("<Result of ")
    assert f"distance {number(result.cost)}, proven optimal" in repr(result)
    assert f"{len(result.plan.trips)} trips, 4 stops" in repr(result.plan)
    assert "4 items, 4 orders, 2 robots" in repr(result.instance)


class Tags(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: set[str] = set()
        self.text = ""

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.seen.add(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def tags_of(text: str) -> Tags:
    parser = Tags()
    parser.feed(text)
    parser.close()
    return parser


def test_tables_are_markup_of_ours_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    result = qrobot.solve(evil(), backend="exact")
    for one in (result, result.plan, result.instance):
        text = one._repr_html_()
        found = tags_of(text)
        assert found.seen <= {"div", "p", "table", "thead", "tbody", "tr", "th", "td", "br"}
        assert "<svg" not in text
        ElementTree.fromstring(text)  # well formed
        text.encode("utf-8")
    for trip in result.plan.trips:
        for stop in trip.stops:
            assert stop.split("<")[0] in tags_of(result._repr_html_()).text


def test_the_picture_is_part_of_it() -> None:
    pytest.importorskip("matplotlib")
    text = qrobot.solve(replace(evil(), name=EVIL), backend="exact")._repr_html_()
    picture = text[text.index("<svg") : text.index("</svg>") + 6]
    ElementTree.fromstring(picture)
    assert "script" not in tags_of(text).seen
    assert "<?xml" not in text
    assert "<!DOCTYPE" not in text


def test_a_picture_that_cannot_be_drawn_costs_no_table(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise TypeError("no picture of this")

    monkeypatch.setattr(qrobot, "plot", fail)
    assert "<table>" in qrobot.solve(paper_shaped(3, 1, 0), backend="exact")._repr_html_()


def test_long_tables_are_counted() -> None:
    rows = [(str(number), "x" * 10_000) for number in range(MOST_ROWS + 7)]
    text = html_table("many", ("number", "text"), rows)
    assert "... and 7 more" in text
    assert text.count("<tr>") == MOST_ROWS + 2
    assert len(text) < MOST_ROWS * 600
