"""No text of a robot becomes markup: a page of hostile words is built like one of tame words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import pytest
from drift_show import page as drift_page
from health import samples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from qrobot.health import Report
from qrobot.health.reports import compare, fleet, fleet_html, html
from qrobot.pages import Bar, bars

Words = Callable[[int], str]

PIECES = (
    "<script>alert(1)</script>", "</style>", "</title>", "<!--", "-->", "]]>", '"', "'", "`", ">",
    "<", "&", "&lt;", '" onload="x', "' style='x", "<img src=x onerror=y>", "<b>", "</td>",
    "{{ 7 }}", "{% raw %}", "javascript:", "\x00", "\n", "\u2028", "ü", "<svg/onload=z>", "\\",
)  # fmt: skip
# Different words stay different, and none is empty.
HOSTILE = st.lists(
    st.lists(st.sampled_from(PIECES) | st.text(max_size=5), min_size=1, max_size=4).map("".join),
    min_size=12, max_size=12,
)  # fmt: skip


class Skeleton(HTMLParser):
    """The elements of a page, each with the names of its attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.found: Counter[tuple[str, ...]] = Counter()
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found[(tag, *(name for name, _ in attrs))] += 1

    def handle_endtag(self, tag: str) -> None:
        self.found["/", tag] += 1

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def handle_comment(self, data: str) -> None:
        self.found["comment", data] += 1


def spoken(host: str, words: Words) -> Report:
    """Return a report in which everything that a robot may say is given."""
    checks = (
        samples.check(words(1), title=words(2), group=words(3), versions={words(4): words(5)}),
        samples.check(words(6), "fail", message=words(7)),
        samples.check(words(8), "absent", message=words(9)),
    )
    finding = replace(samples.FINDINGS[2], name=words(10), title=words(11), message=words(0))
    return samples.report(
        host, model=words(1), python=words(2), machine=words(3), qrobot=words(4),
        checks=checks, system=(finding, replace(samples.FINDINGS[0], value=words(5))),
    )  # fmt: skip


def drifted(words: Words) -> dict[str, Any]:
    """Return a document qrobot.drift/1 in which everything that a robot may say is given."""
    robot = {
        "name": words(0), "profile": words(1), "state": "drift", "why": "",
        "release": {"in_use": words(2), "wanted": words(3)},
        "packages": {
            "missing": {words(4): words(5)}, "extra": {words(6): words(7)},
            "other": {words(8): {"has": words(9), "lock": words(10)}},
        },
        "drift": [words(11)], "notes": [words(1)],
        "differs": [{"kind": "file", "name": words(2), "among": words(3), "has": words(4),
                     "majority": words(5)}],
    }  # fmt: skip
    silent = robot | {"name": words(6), "state": "unreachable", "why": words(7)}
    odd = {"kind": "unit", "name": words(8), "among": words(9), "majority": words(10),
           "different": {words(11): [words(0)]}}  # fmt: skip
    return {
        "made": "2026-11-20T08:00:00+00:00", "version": "0.1.0", "robots": [robot, silent],
        "totals": {"same": 0, "drift": 1, "unreachable": 1}, "differences": [odd],
    }  # fmt: skip


def one(words: Words) -> str:
    report = spoken(words(0), words)
    return html(report, compare(samples.report(), report))


def many(words: Words) -> str:
    return fleet_html(fleet([spoken(words(0), words), samples.report("b"), samples.report("c")]))


def chart(words: Words) -> str:
    return bars("x", words(0), [Bar(words(1), (1.0, 2.0), words(2))], (words(3), words(4)))


PAGES = {
    "report": one,
    "fleet": many,
    "drift": lambda words: drift_page(drifted(words)),
    "chart": chart,
}


@pytest.mark.parametrize("name", PAGES)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(hostile=HOSTILE)
def test_words_stay_words(name: str, hostile: list[str]) -> None:
    page = PAGES[name]
    got = Skeleton(page(lambda k: f"{k}{hostile[k]}"))
    assert got.found == Skeleton(page(lambda k: f"{k}tame")).found


def test_the_control_markup_would_be_seen() -> None:
    tame = one(lambda k: f"{k}tame")
    raw = tame.replace("7tame", "7<script>alert(1)</script>", 1)
    assert Skeleton(raw).found != Skeleton(tame).found
    escaped = one(lambda k: f"{k}<b>&'\"")
    assert "7<b>&'\"" in "".join(Skeleton(escaped).words)
