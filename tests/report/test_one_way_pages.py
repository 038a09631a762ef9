"""Pages show which parts of a warehouse are walked in one direction only."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from health.browser import browser, needs_chromium
from report.animated import page_of

import qrobot
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot
from qrobot.report import pick_lists, picklist_page

ONE_WAY = {"one_way_aisles": frozenset({(1, 0, "back"), (2, 0, "front")})}
ACROSS = {"one_way_crossings": frozenset({(0, 0, "left"), (1, 1, "right")})}


def asked(house: AisleWarehouse) -> Instance:
    items = (Item("i0", 1, Slot(1, 2)), Item("i1", 1, Slot(2, 3)))
    return Instance(house, items, (Order("o0", ("i0", "i1")),), (Robot("R1", 2),))


def pages(house: AisleWarehouse, folder: Path) -> list[str]:
    """Return the animated page and that of pick lists."""
    instance = asked(house)
    plan = qrobot.solve(instance, max_work=20).plan
    return [page_of(plan, instance, folder), picklist_page(pick_lists(plan, instance))]


def headings(page: str) -> set[tuple[int, int]]:
    """Return where the arrows of one-way parts point: right and up are positive."""
    (group,) = re.findall(r'<g class="one-way">.*?</g>', page, re.DOTALL)
    found = set()
    for points in re.findall(r'points="([^"]+)"', group):
        tip, left, right = (tuple(map(float, p.split(","))) for p in points.split())
        ahead = [a - (b + c) / 2 for a, b, c in zip(tip, left, right, strict=True)]
        found.add((round(ahead[0] / 6), round(-ahead[1] / 6)))
    lines = re.findall(r"M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)", group)
    signs = {
        (int(float(bx) > float(ax)) - int(float(bx) < float(ax)),
         int(float(by) < float(ay)) - int(float(by) > float(ay)))
        for ax, ay, bx, by in lines
    }  # fmt: skip
    assert signs == found
    return found


@pytest.mark.parametrize(
    ("directions", "expected"),
    [(ONE_WAY, {(0, 1), (0, -1)}), (ACROSS, {(-1, 0), (1, 0)})],
    ids=["aisles", "cross-aisles"],
)
def test_arrows_point_where_pickers_may_walk(
    directions: dict[str, frozenset[tuple[int, int, str]]],
    expected: set[tuple[int, int]],
    tmp_path: Path,
) -> None:
    for page in pages(AisleWarehouse(4, 5, **directions), tmp_path):  # type: ignore[arg-type]
        assert headings(page) == expected


def test_aisles_walked_both_ways_have_none(tmp_path: Path) -> None:
    for page in pages(AisleWarehouse(4, 5), tmp_path):
        assert 'class="one-way"' not in page


@needs_chromium
def test_arrows_are_seen_in_a_browser(tmp_path: Path) -> None:
    seen = "[...document.querySelectorAll('.one-way polygon')].map(p => p.getBoundingClientRect())"
    written = pages(AisleWarehouse(4, 5, **ONE_WAY), tmp_path)  # type: ignore[arg-type]
    with browser() as chromium:
        for number, text in enumerate(written):
            page = tmp_path / f"{number}.html"
            page.write_text(text)
            chromium.open(page, 900)
            widths = chromium.ask(f"{seen}.map(box => Math.min(box.width, box.height))")
            assert len(widths) >= 2
            assert min(widths) > 3
