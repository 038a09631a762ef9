"""The animated page in a real browser: slider, keyboard, little motion, no script but its own."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from health.browser import Browser, browser, needs_chromium
from report.animated import XY, Page, at, page_of, timed
from scenes import CASES, shared
from slow import slow

import qrobot
from qrobot.plan import Plan

pytestmark = needs_chromium


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


@pytest.mark.parametrize("width", [slow(1200), 390])
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
