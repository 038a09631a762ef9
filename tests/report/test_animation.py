"""The animated page: its times and places against the plan, and its controls in a real browser."""

from __future__ import annotations

import json
import math
import sys
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from health.browser import Browser, browser, needs_chromium
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CASES, LAYOUT, shared

import qrobot
from qrobot.plan import OBJECTIVES, Plan
from qrobot.problem import AisleWarehouse, Instance
from qrobot.problem.names import canonical
from qrobot.report import check_picture_path, plot

XY = tuple[float, float]


class Page(HTMLParser):
    """The data of a page, and its tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.data: dict[str, Any] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        found = dict(attributes)
        assert not any(name.startswith("on") for name in found)
        if "data-plan" in found:
            self.data = json.loads(found["data-plan"] or "")


def timed(instance: Instance) -> Instance:
    """Return the question with robots of unlike speed and picks that take a while."""
    return replace(
        instance,
        items=tuple(
            replace(item, pick_seconds=float(k % 4)) for k, item in enumerate(instance.items)
        ),
        robots=tuple(
            replace(robot, speed=0.5 + 0.25 * k) for k, robot in enumerate(instance.robots)
        ),
    )


def page_of(plan: Plan, instance: Instance, folder: Path) -> str:
    plot(plan, folder / "page.html", instance)
    return (folder / "page.html").read_text()


def at(trip: dict[str, Any], moment: float) -> XY:
    """Return where a robot is at a moment, from the frames."""
    k = bisect_right(trip["t"], moment)
    if k == 0:
        return trip["x"][0], trip["y"][0]
    if k == len(trip["t"]):
        return trip["x"][-1], trip["y"][-1]
    share = (moment - trip["t"][k - 1]) / (trip["t"][k] - trip["t"][k - 1])
    x, y = (trip[n][k - 1] + share * (trip[n][k] - trip[n][k - 1]) for n in "xy")
    return x, y


def off(point: XY, line: list[XY]) -> float:
    """Return how far a point is from a line of several parts."""
    best = math.dist(point, line[0])
    for a, b in pairwise(line):
        length = math.dist(a, b)
        along = sum((q - p) * (r - p) for p, q, r in zip(a, b, point, strict=True))
        share = min(max(along / length**2, 0), 1) if length else 0.0
        nearest = [p + share * (q - p) for p, q in zip(a, b, strict=True)]
        best = min(best, math.dist(point, nearest))
    return best


@pytest.mark.parametrize("case", CASES)
def test_robots_are_where_and_when_a_walk_would_have_them(case: str, tmp_path: Path) -> None:
    instance = timed(CASES[case])
    plan = shared(instance, 14 if case == "many" else 3)
    data = Page(page_of(plan, instance, tmp_path)).data
    items = {item.id: item for item in instance.items}
    speeds = {robot.id: robot.speed for robot in instance.robots}
    metres: list[XY] = []
    drawn: list[XY] = []
    assert len(data["robots"]) == len(plan.trips)  # each makes one
    for trip, robot in zip(plan.trips, data["robots"], strict=True):
        (shown,) = robot["trips"]
        stops = [items[stop] for stop in trip.stops]
        ways = instance.warehouse.distance_matrix([item.place for item in stops])
        clock = 0.0
        for k, item in enumerate(stops):
            clock += float(ways[k, k + 1]) / speeds[trip.robot]
            assert shown["arrives"][k] == pytest.approx(clock, abs=2e-3)
            metres.append(instance.warehouse.position(item.place))
            drawn.append(at(shown, clock))
            clock += item.pick_seconds
            assert shown["leaves"][k] == pytest.approx(clock, abs=2e-3)
            assert shown["labels"][k].endswith(f": {item.id}")
        clock += float(ways[len(stops), 0]) / speeds[trip.robot]
        assert shown["end"] == pytest.approx(clock, abs=2e-3)
        assert shown["t"] == sorted(shown["t"])
        metres.append(instance.warehouse.depot)
        drawn.append(at(shown, clock))
    assert data["end"] == pytest.approx(max(r["trips"][0]["end"] for r in data["robots"]))
    # One scale for both directions, y downwards, fits all stops: but for the lane in the aisle.
    (scale, left, top), lane = fitted(metres, drawn)
    house = instance.warehouse
    wide = scale * (house.aisle_pitch if isinstance(house, AisleWarehouse) else 0.0)
    assert lane <= max(0.3 * wide, 15.0 if case == "manhattan" else 0.2)
    # And between the stops they keep to the real ways.
    for trip, robot in zip(plan.trips, data["robots"], strict=True):
        (shown,) = robot["trips"]
        places = [None, *(items[stop].place for stop in trip.stops), None]
        times = [
            0.0,
            *(t for pair in zip(shown["arrives"], shown["leaves"], strict=True) for t in pair),
            shown["end"],
        ]
        for k, (a, b) in enumerate(pairwise(places)):
            line = [(left + scale * x, top - scale * y) for x, y in house.way(a, b)]
            for moment in np.linspace(times[2 * k], times[2 * k + 1], 9):
                assert off(at(shown, float(moment)), line) <= lane + 1.5


def fitted(metres: list[XY], drawn: list[XY]) -> tuple[tuple[float, float, float], float]:
    """Return scale and shift from metres to the drawing, and the largest distance that is left."""
    rows, values = [], []
    for (x, y), (px, py) in zip(metres, drawn, strict=True):
        rows += [(x, 1, 0), (-y, 0, 1)]
        values += [px, py]
    found, *_ = np.linalg.lstsq(np.array(rows, dtype=float), np.array(values), rcond=None)
    rest = (np.array(rows) @ found - values).reshape(-1, 2)
    return (float(found[0]), float(found[1]), float(found[2])), float(np.hypot(*rest.T).max())


def test_the_time_of_all_robots_is_that_of_the_objective(tmp_path: Path) -> None:
    instance = timed(CASES["closed"])
    plan = shared(instance)
    timed_plan = Plan.from_routes(instance, plan.routes(instance), OBJECTIVES["time"])
    data = Page(page_of(timed_plan, instance, tmp_path)).data
    total = sum(trip["end"] - trip["start"] for r in data["robots"] for trip in r["trips"])
    assert total == pytest.approx(timed_plan.cost, abs=0.01)


def test_a_robot_makes_its_trips_one_after_the_other(tmp_path: Path) -> None:
    instance = CASES["aisles"]
    instance = replace(instance, robots=(replace(instance.robots[0], trips=3),))
    (robot,) = Page(page_of(shared(instance), instance, tmp_path)).data["robots"]
    assert robot["trips"][0]["start"] == 0
    for before, after in pairwise(robot["trips"]):
        assert after["start"] == before["end"]
    assert robot["picks"] == instance.size == sum(len(t["labels"]) for t in robot["trips"])
    assert len({trip["fill"] for trip in robot["trips"]}) == 3


NAMES = st.text(st.sampled_from("<>&\"'=+-/\\{}%#; abשלום\u0301"), min_size=1, max_size=14).filter(
    lambda name: name.strip() != ""
)


@settings(max_examples=40, deadline=None)
@given(st.lists(NAMES, min_size=4, max_size=4, unique_by=canonical))
def test_odd_names_are_text_and_nothing_else(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    plain = CASES["aisles"]
    one = replace(
        plain,
        items=(replace(plain.items[0], id=names[0], article="</script><b>&amp;"),),
        orders=(qrobot.Order(names[1], (names[0],)),),
        robots=(replace(plain.robots[0], id=names[2]),),
        name=names[3],
    )
    page = Page(page_of(Plan.from_routes(one, [[1]]), one, tmp_path_factory.mktemp("odd")))
    assert page.tags.count("script") == 1
    assert set(page.tags) <= {
        "html", "head", "meta", "title", "link", "style", "body", "main", "h1", "p", "noscript",
        "div", "button", "input", "output", "label", "select", "option", "figure", "svg", "rect",
        "path", "g", "text", "circle", "polygon", "table", "caption", "thead", "tr", "th", "tbody",
        "td", "span", "script",
    }  # fmt: skip
    assert page.data["robots"][0]["trips"][0]["labels"][0].endswith(": </script><b>&amp;")


def test_a_page_needs_no_drawing_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "<svg" in page_of(shared(CASES["table"]), CASES["table"], tmp_path)


def test_only_a_plan_moves() -> None:
    with pytest.raises(qrobot.InputError, match=r"end it with \.svg or \.png$"):
        check_picture_path("gaps.html")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    instance = timed(CASES["closed"])
    page_of(shared(instance), instance, folder)
    return folder / "page.html"


def slide(chromium: Browser, moment: float) -> None:
    chromium.ask(f"time.value = {moment}; time.dispatchEvent(new Event('input')); undefined")


def markers(chromium: Browser) -> list[XY]:
    texts = chromium.ask(
        "[...document.querySelectorAll('.robot')].map(r => r.getAttribute('transform'))"
    )
    return [tuple(map(float, text[len("translate(") : -1].split()))[:2] for text in texts]  # type: ignore[misc]


def press(chromium: Browser, key: str) -> None:
    code = {"key": key, "code": "Space" if key == " " else key}
    text = {"text": " "} if key == " " else {}
    chromium.call("Input.dispatchKeyEvent", type="keyDown", **code, **text)
    chromium.call("Input.dispatchKeyEvent", type="keyUp", **code)


def await_move(chromium: Browser, since: float) -> float:
    """Return the time of the page as soon as it is past another one."""
    wait = f"""new Promise(done => {{ const look = () => Number(time.value) > {since}
        ? done(Number(time.value)) : requestAnimationFrame(look); look(); }})"""
    found = chromium.call(
        "Runtime.evaluate", expression=wait, awaitPromise=True, returnByValue=True
    )
    return float(found["result"]["value"])


@needs_chromium
@pytest.mark.parametrize("width", [1200, 390])
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_the_page_fits_the_screen_and_asks_for_nothing(
    chromium: Browser, page: Path, width: int, dark: bool
) -> None:
    chromium.open(page, width, dark=dark)
    assert chromium.requests == [page.as_uri()]
    assert chromium.complaints == []  # the page's own policy lets its script run
    assert chromium.ask("document.documentElement.scrollWidth") == width
    assert chromium.ask("controls.hidden") is False
    back = chromium.ask("getComputedStyle(document.body).backgroundColor")
    assert back == ("rgb(18, 22, 28)" if dark else "rgb(251, 251, 253)")
    assert chromium.ask("document.querySelector('.map').clientWidth") > 0.75 * min(width, 500)
    wide = """[...document.querySelectorAll('main *')].filter(e => !e.closest('svg *') &&
        !e.closest('.unseen') && e.getBoundingClientRect().right > innerWidth + 1).length"""
    assert chromium.ask(wide) == 0


@needs_chromium
def test_the_slider_puts_the_robots_where_the_plan_has_them(chromium: Browser, page: Path) -> None:
    chromium.open(page, 1200)
    data = Page(page.read_text()).data
    for share in (0.0, 0.1, 0.37, 0.5, 0.81, 1.0):
        moment = share * data["end"]
        slide(chromium, moment)
        for robot, found, number in zip(data["robots"], markers(chromium), range(9), strict=False):
            assert found == pytest.approx(at(robot["trips"][0], moment), abs=0.2)
            done = bisect_right(robot["trips"][0]["leaves"], moment)
            assert chromium.ask(f"document.getElementById('done-{number}').textContent") == (
                f"{done} of {robot['picks']}"
            )
            load = robot["trips"][0]["loads"][done - 1] if done else "0"
            assert chromium.ask(f"document.getElementById('load-{number}').textContent") == (
                f"{load} of {robot['capacity']}"
            )
    assert chromium.ask("document.querySelectorAll('.mark:not(.done)').length") == 0
    assert chromium.ask("document.getElementById('does-0').textContent") == "at the depot"
    slide(chromium, 0)
    assert chromium.ask("document.querySelectorAll('.mark.done').length") == 0


@needs_chromium
def test_it_plays_pauses_and_obeys_the_keyboard(chromium: Browser, page: Path) -> None:
    chromium.open(page, 1200)
    end = Page(page.read_text()).data["end"]
    assert chromium.ask("[time.value, play.textContent]") == ["0", "Play"]
    press(chromium, " ")
    assert chromium.ask("play.textContent") == "Pause"
    first = markers(chromium)
    await_move(chromium, 0.5)
    press(chromium, " ")
    assert chromium.ask("play.textContent") == "Play"
    held = float(chromium.ask("time.value"))
    assert markers(chromium) != first
    # Two frames later it still stands.
    two = (
        "new Promise(d => requestAnimationFrame(() => requestAnimationFrame(() => d(time.value))))"
    )
    found = chromium.call("Runtime.evaluate", expression=two, awaitPromise=True, returnByValue=True)
    assert float(found["result"]["value"]) == held
    press(chromium, "End")
    assert float(chromium.ask("time.value")) == pytest.approx(end)
    press(chromium, "ArrowLeft")
    assert float(chromium.ask("time.value")) == pytest.approx(0.98 * end)
    press(chromium, "Home")
    assert chromium.ask("time.value") == "0"
    # A focused button gets the space bar itself, and the slider the arrows: once, not twice.
    chromium.ask("play.focus()")
    press(chromium, " ")
    assert chromium.ask("play.textContent") == "Pause"
    chromium.ask("speed.value = 100000; undefined")
    await_move(chromium, end - 1e-3)
    assert chromium.ask("play.textContent") == "Play"  # at its end it stops
    chromium.ask("time.focus()")
    press(chromium, "Home")
    assert chromium.ask("time.value") == "0"
    assert "0:00 of" in chromium.ask("time.getAttribute('aria-valuetext')")


@needs_chromium
def test_who_wants_little_motion_sees_robots_at_stops_only(chromium: Browser, page: Path) -> None:
    chromium.open(page, 1200)
    chromium.call(
        "Emulation.setEmulatedMedia",
        features=[{"name": "prefers-reduced-motion", "value": "reduce"}],
    )
    data = Page(page.read_text()).data
    seen = set()
    for k in range(30):
        slide(chromium, k / 29 * data["end"])
        trip = data["robots"][0]["trips"][0]
        places = [at(trip, t) for t in (0.0, *trip["leaves"], trip["end"])]
        found = markers(chromium)[0]
        assert min(math.dist(found, place) for place in places) < 0.2
        seen.add(found)
    assert len(seen) > 3


@needs_chromium
def test_no_other_script_runs_and_without_any_the_ways_are_there(
    chromium: Browser, page: Path, tmp_path: Path
) -> None:
    changed = tmp_path / "page.html"
    changed.write_text(
        page.read_text().replace("</main>", "<script>window.bad = 1</script></main>")
    )
    chromium.open(changed, 1200)
    assert chromium.ask("window.bad") is None
    assert any("Content Security Policy" in text for text in chromium.complaints)
    chromium.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        chromium.open(page, 1200)
        assert chromium.ask("controls.hidden") is True
        assert chromium.ask("document.querySelectorAll('path.way').length") == 3
        assert chromium.ask("document.querySelector('noscript p').clientHeight") > 0
    finally:
        chromium.call("Emulation.setScriptExecutionDisabled", value=False)


def test_two_trips_in_one_slot_have_a_part_of_it_each(tmp_path: Path) -> None:
    plain = CASES["aisles"]
    place = plain.items[0].place
    one = replace(
        plain,
        warehouse=LAYOUT,
        items=tuple(replace(item, place=place) for item in plain.items[:2]),
        orders=plain.orders[:2],
    )
    text = page_of(Plan.from_routes(one, [[1], [2]]), one, tmp_path)
    boxes = [part.split('"') for part in text.split('class="mark" ')[1:]]
    (x1, w1), (x2, w2) = sorted((float(b[1]), float(b[5])) for b in boxes)
    assert x1 + w1 == pytest.approx(x2, abs=0.02)
    assert w1 == w2


@needs_chromium
def test_plans_without_a_way_are_pages_too(chromium: Browser, tmp_path: Path) -> None:
    plain = CASES["there and back"]
    nothing = replace(plain, items=(), orders=())
    at_depot = replace(plain.items[0], place=qrobot.problem.Point(0, 0))
    unmoved = replace(plain, items=(at_depot,), orders=plain.orders[:1])
    for one, robots in ((nothing, 0), (unmoved, 1)):
        page_of(Plan.from_routes(one, [[1]] if robots else []), one, tmp_path)
        chromium.open(tmp_path / "page.html", 700)
        assert chromium.complaints == []
        assert chromium.ask("clock.textContent") == "0:00 of 0:00"
        assert chromium.ask("document.querySelectorAll('.robot').length") == robots
        chromium.ask("play.click()")
        assert chromium.ask("document.querySelectorAll('.mark.done').length") == robots
