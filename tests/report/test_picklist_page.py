"""The page of pick lists: escaped, in a real browser, and on paper."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from health.browser import Browser, browser, needs_chromium
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CASES, shared

import qrobot
from qrobot.plan import Plan
from qrobot.problem.checks import canonical
from qrobot.report import PickLists, pick_lists, picklist_page

SLOW = pytest.mark.slow
PAPERS = {"a4": (210, 297), "a5": (148, 210), "label": (100, 150)}


class Cells(HTMLParser):
    """The text of every cell of the tables' bodies, and the tags of the page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.tags: set[str] = set()
        self._inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        given = dict(attributes)
        assert not any(name.startswith("on") for name in given)
        self._inside = given.get("role") in {"rowheader", "cell"} or (
            self._inside and tag == "span"
        )
        if given.get("role") == "rowheader":
            self.rows.append([])
        if given.get("role") in {"rowheader", "cell"}:
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = self._inside and tag not in {"td", "th"}

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.rows[-1][-1] += data


def lists_of(case: str, trips: int = 3) -> PickLists:
    return pick_lists(shared(CASES[case], trips), CASES[case])


@pytest.mark.parametrize("case", CASES)
def test_the_tables_say_what_the_lists_say(case: str) -> None:
    lists = lists_of(case, 14 if case == "many" else 3)
    found = Cells(picklist_page(lists)).rows
    assert [[row[0], row[2], row[3], row[4]] for row in found] == [
        [str(pick.stop), pick.article, str(pick.item.quantity), str(pick.basket)]
        for one in lists.lists
        for pick in one.picks
    ]
    assert [float(row[5]) for row in found] == [
        float(pick.load) for one in lists.lists for pick in one.picks
    ]


NAMES = st.text(st.sampled_from("<>&\"'=+-@/\\{}%#; abשלום\u0301"), min_size=1, max_size=14).filter(
    lambda name: name.strip() != ""
)


@settings(max_examples=60, deadline=None)
@given(st.lists(NAMES, min_size=7, max_size=7, unique_by=canonical))
def test_odd_names_are_text_and_nothing_else(names: list[str]) -> None:
    plain = CASES["aisles"]
    one = replace(
        plain,
        items=tuple(
            replace(item, id=name, article=f"<b>{name}")
            for item, name in zip(plain.items[:2], names, strict=False)
        ),
        orders=(qrobot.Order(names[2], names[:2]),),
        robots=(replace(plain.robots[0], id=names[3]),),
        name=names[4],
    )
    text = picklist_page(pick_lists(Plan.from_routes(one, [[2, 1]]), one))
    usual = Cells(picklist_page(lists_of("aisles")))
    page = Cells(text)
    assert page.tags <= usual.tags
    assert "b" not in page.tags
    assert [row[2] for row in page.rows] == [
        one.items[1].article, one.items[0].article,
    ]  # fmt: skip
    assert "script" not in text


def test_other_paper_is_refused() -> None:
    with pytest.raises(qrobot.InputError, match="'a3' is not a paper; use one of: a4, a5, label"):
        picklist_page(lists_of("aisles"), "a3")


def test_robots_that_stay_home_are_named() -> None:
    lists = pick_lists(shared(CASES["aisles"], 2), CASES["aisles"], ["R3"])
    assert "Without a trip: R3." in picklist_page(lists)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


def printed(chromium: Browser, page: Path) -> tuple[int, list[float]]:
    """Return the number of sheets and the size of the first, mm."""
    chromium.open(page, 1000)
    options: dict[str, Any] = {"preferCSSPageSize": True, "printBackground": True}
    pdf = base64.b64decode(chromium.call("Page.printToPDF", **options)["data"])
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert box
    return len(re.findall(rb"/Type /Page\b", pdf)), [float(v) * 25.4 / 72 for v in box.groups()]


@needs_chromium
@pytest.mark.parametrize("width", [1200, 390])
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize(
    "case", ["many", *(pytest.param(c, marks=SLOW) for c in ("closed", "manhattan", "table"))]
)
def test_a_page_fits_the_screen_and_asks_for_nothing(
    chromium: Browser, tmp_path: Path, case: str, width: int, dark: bool
) -> None:
    page = tmp_path / "page.html"
    page.write_text(picklist_page(lists_of(case)))
    chromium.open(page, width, dark=dark)
    assert chromium.requests == [page.as_uri()]
    assert chromium.complaints == []
    assert chromium.ask("document.documentElement.scrollWidth") == width
    out = """[...document.querySelectorAll('svg')].flatMap(s => [...s.querySelectorAll('*')].filter(
        e => e.getBoundingClientRect && e.tagName != 'title' && e.tagName != 'g').filter(e => {
        const a = e.getBoundingClientRect(), b = s.getBoundingClientRect();
        return a.left < b.left - 1 || a.right > b.right + 1 || a.top < b.top - 1 ||
            a.bottom > b.bottom + 1 })).length"""
    assert chromium.ask(out) == 0
    assert chromium.ask("document.querySelectorAll('.sheet svg path.way').length") == 3
    if case in ("closed", "many"):  # the racks, which all maps have from the first one
        shades = (
            "new Set([...document.querySelectorAll('.rack')].map(r => getComputedStyle(r).fill))"
        )
        assert chromium.ask(f"[...{shades}]") == [
            "rgb(58, 69, 82)" if dark else "rgb(213, 219, 226)"
        ]
        assert (
            chromium.ask("""[...document.querySelectorAll('use')].filter(u =>
            u.getBoundingClientRect().height < 50).length""")
            == 0
        )
    back = chromium.ask("getComputedStyle(document.body).backgroundColor")
    assert back == ("rgb(18, 22, 28)" if dark else "rgb(251, 251, 253)")


@needs_chromium
@pytest.mark.parametrize("paper", PAPERS)
def test_each_trip_is_printed_on_a_sheet_of_its_own(
    chromium: Browser, tmp_path: Path, paper: str
) -> None:
    page = tmp_path / "page.html"
    short = shared(CASES["aisles"], 2)  # ten picks each
    page.write_text(picklist_page(pick_lists(short, CASES["aisles"]), paper))
    sheets, size = printed(chromium, page)
    assert sheets == 2
    assert size == pytest.approx(PAPERS[paper], abs=0.6)
    page.write_text(picklist_page(pick_lists(short, CASES["aisles"], ["R2"]), paper))
    assert printed(chromium, page)[0] == 1


@needs_chromium
def test_a_long_list_goes_on_under_the_name_of_its_robot(chromium: Browser, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(picklist_page(lists_of("many", 1), "label"))
    sheets, _ = printed(chromium, page)
    assert 3 <= sheets <= 5  # 60 picks, about twenty on a label
    chromium.open(page, 348)
    chromium.call("Emulation.setEmulatedMedia", media="print")
    try:
        shown = "getComputedStyle(document.querySelector('.which')).display"
        assert chromium.ask(shown) == "table-row"
        assert chromium.ask("getComputedStyle(document.querySelector('thead')).display") == (
            "table-header-group"
        )
        assert chromium.ask("document.documentElement.scrollWidth") == 348
    finally:
        chromium.call("Emulation.setEmulatedMedia", media="")
