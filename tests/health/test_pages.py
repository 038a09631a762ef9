"""The pages, read by a parser: they need nothing but themselves, and can be heard."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from health import samples
from health.samples import BROKEN, MIXED, STRANGE

from qrobot.health.reports import compare, fleet, fleet_html, html
from qrobot.pages import Bar, bars


class Reader(HTMLParser):
    """Holds tags against each other, and gathers what a test asks about."""

    VOID = frozenset({"meta", "link", "br", "line", "rect"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def named(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


PAGES = {
    "mixed": html(BROKEN, compare(samples.report(), BROKEN)),
    "healthy": html(samples.report()),
    "nothing": html(replace(MIXED, checks=(), system=())),
    "nasty": html(STRANGE, compare(samples.report(), STRANGE)),
    "fleet": fleet_html(fleet([samples.report("a"), samples.report("b"), BROKEN])),
    "nasty fleet": fleet_html(fleet([STRANGE, samples.report("b"), BROKEN])),
}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_needs_nothing_but_itself(name: str) -> None:
    page = Reader(PAGES[name])
    assert page.named("html") == [{"lang": "en"}]
    assert len(page.named("title")) >= 1
    assert not page.named("script")
    assert not page.named("img")
    assert not page.named("iframe")
    assert page.named("link") == [{"rel": "icon", "href": "data:,"}]
    for tag, attributes in page.tags:
        assert not {"src", "srcset", "onload", "onclick", "style"} & set(attributes), tag
    assert "://" not in PAGES[name]
    assert "@import" not in PAGES[name]
    assert "url(" not in PAGES[name]
    assert page.named("b") == [{}] * len(page.named("b"))
    identities = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(identities) == len(set(identities))


@pytest.mark.parametrize("name", PAGES)
def test_a_page_can_be_heard(name: str) -> None:
    page = Reader(PAGES[name])
    assert len(page.named("table")) == len(page.named("caption"))
    assert all(head.get("scope") in ("col", "row") for head in page.named("th"))
    for chart in page.named("svg"):
        assert chart["role"] == "img"
        assert {"id": chart["aria-labelledby"]} in page.named("title")
    assert len(page.named("h1")) == 1


def test_failures_are_on_top() -> None:
    text = PAGES["mixed"]
    heads = re.findall(r"<h2>(.*?)</h2>", text)
    assert heads == ["Needs attention", "Drift", "Time and memory", "Checks", "Machine", "Versions"]
    items = re.findall(r'<li><span class="badge (\w+)"', text)
    assert set(items[:3]) == {"fault", "fail", "error"}
    assert set(items[3:]) == {"warning", "absent"}
    assert "Needs attention" in PAGES["healthy"]  # its warning
    assert "Needs attention" not in PAGES["nothing"]


def luminance(colour: str) -> float:
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_contrast_is_that_of_wcag_aa(scheme: int) -> None:
    blocks = re.findall(r":root \{(.*?)\}", PAGES["mixed"], re.DOTALL)
    colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", blocks[scheme]))
    pairs = [
        *((ink, paper) for ink in ("ink", "soft") for paper in ("paper", "card")),
        *((kind, f"{kind}-back") for kind in ("good", "bad", "warn", "none")),
    ]
    for one, other in pairs:
        light, dark = sorted((luminance(colours[one]), luminance(colours[other])), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 4.5, (one, other)
    for part in ("part0", "part1"):  # what is drawn needs less
        light, dark = sorted((luminance(colours[part]), luminance(colours["card"])), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 3, part


def test_bars_are_as_long_as_their_numbers() -> None:
    drawn = bars("x", "Lengths", [Bar("a", (1.0, 2.0), "3"), Bar("b", (1.5,), "1.5")], ("p", "q"))
    widths = [float(width) for width in re.findall(r'width="([\d.]+)"', drawn)]
    assert widths[1] == pytest.approx(2 * widths[0], abs=0.2)
    assert widths[2] == pytest.approx(1.5 * widths[0], abs=0.2)
    starts = [float(x) for x in re.findall(r'<rect class="part\d" x="([\d.]+)"', drawn)]
    assert starts[1] == pytest.approx(starts[0] + widths[0], abs=0.2)
    ends = [float(tick) for tick in re.findall(r'class="tick"[^>]*>([\d.]+)<', drawn)]
    assert ends == [0.0, 2.5, 5.0]


@pytest.mark.parametrize("value", [0.0, 1e-9, 0.999, 1.0, 1e12])
def test_no_bar_leaves_its_chart(value: float) -> None:
    drawn = bars("x", "t", [Bar("a", (value,), "")])
    (rect,) = re.findall(r'<rect class="part0" x="([\d.]+)" y="\d+" width="([\d.]+)"', drawn)
    (width,) = re.findall(r'viewBox="0 0 (\d+)', drawn)
    assert sum(map(float, rect)) <= float(width)
