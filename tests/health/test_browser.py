"""The pages in a real browser: drawn, readable on a telephone, silent on the network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from health import samples
from health.browser import Browser, browser, needs_chromium

from qrobot.health import Report
from qrobot.health.reports import compare, fleet, fleet_html, html

pytestmark = needs_chromium

NAMES = ("numpy", "qiskit-machine-learning", "a-check-with-a-very-long-name-that-nobody-gave")


def long_report(host: str = "pi-01") -> Report:
    words = "a sentence of some length that has to be broken somewhere, with /a/path/" + "x" * 120
    return replace(
        samples.report(host),
        model="Raspberry Pi 4 Model B Rev 1.4 " + "y" * 60,
        checks=tuple(
            samples.check(f"{name}-{k}", "error" if k == 3 else "pass", message=words)
            for k in range(10)
            for name in NAMES
        ),
        system=(*samples.FINDINGS, replace(samples.FINDINGS[0], name="z", message=words)),
    )


@pytest.fixture(scope="module")
def page() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture(params=["one", "fleet"])
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    target = tmp_path / "page.html"
    if request.param == "one":
        target.write_text(html(long_report(), compare(samples.report(), long_report())))
    else:
        machines = [samples.report(f"pi-{k}") for k in range(48)]
        odd = replace(long_report("pi-48"), python="3.13.5")
        versions = {f"package-{k}": f"1.{k}" for k in range(20)}
        other = samples.changed(samples.report("pi-49"), "numpy", versions=versions)
        target.write_text(fleet_html(fleet([*machines, odd, other])))
    return target


@pytest.mark.parametrize("width", [pytest.param(1200, marks=pytest.mark.slow), 375])
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_page_is_drawn(page: Browser, path: Path, width: int, dark: bool) -> None:
    page.open(path, width, dark=dark)
    assert page.requests == [path.as_uri()]
    assert page.complaints == []
    assert page.ask("document.documentElement.scrollWidth") == width
    # Nothing sticks out, but inside what is made to be scrolled.
    wide = """[...document.querySelectorAll('main *')].filter(e => !e.closest('.scroll > *') &&
        !e.closest('svg *') && e.getBoundingClientRect().right > innerWidth + 1).length"""
    assert page.ask(wide) == 0
    assert page.ask("document.querySelectorAll('svg rect').length") >= 20
    assert page.ask(
        "Math.min(...[...document.querySelectorAll('svg')].map(s => s.clientWidth))"
    ) > (250 if width == 375 else 400)
    small = """Math.min(...[...document.querySelectorAll('svg text')].map(t =>
        parseFloat(getComputedStyle(t).fontSize) *
        t.ownerSVGElement.clientWidth / t.ownerSVGElement.viewBox.baseVal.width))"""
    assert page.ask(small) >= 10
    back = page.ask("getComputedStyle(document.body).backgroundColor")
    assert back == ("rgb(18, 22, 28)" if dark else "rgb(251, 251, 253)")
    assert page.picture(path.with_suffix(".png")).startswith(b"\x89PNG")


def test_names_stay_inside_their_chart(page: Browser, path: Path) -> None:
    for width in (1200, 375):
        page.open(path, width)
        out = """[...document.querySelectorAll('svg text')].filter(t => {
            const a = t.getBoundingClientRect(), b = t.ownerSVGElement.getBoundingClientRect();
            return a.left < b.left - 1 || a.right > b.right + 1 }).map(t => t.textContent)"""
        assert page.ask(out) == []


def test_the_control_a_request_would_be_seen_and_refused(page: Browser, tmp_path: Path) -> None:
    target = tmp_path / "page.html"
    text = html(samples.report())
    target.write_text(text.replace("<main>", '<main><img src="http://127.0.0.1:9/x.png" alt="">'))
    page.open(target, 1200)
    assert any("Content Security Policy" in text for text in page.complaints)
    policy = text[text.index('<meta http-equiv="Content-Security') :].partition("\n")[0]
    target.write_text(target.read_text().replace(policy, ""))
    page.open(target, 1200)
    assert "http://127.0.0.1:9/x.png" in page.requests
