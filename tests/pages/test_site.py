"""The built site: it asks no other server, its links lead somewhere, nothing is left out."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from health.browser import Browser, browser, needs_chromium
from pages.blocks import ROOT

import qrobot
from qrobot.health.checks import all_checks

pytest.importorskip("mkdocs", reason="the extra docs is not installed")

LOADS = {
    ("script", "src"), ("img", "src"), ("img", "srcset"), ("iframe", "src"), ("source", "src"),
    ("embed", "src"), ("object", "data"), ("video", "src"), ("audio", "src"), ("image", "href"),
    ("use", "href"),
}  # fmt: skip
"""What a browser fetches by itself; of links see `Page`."""

SCHEMA = re.compile(r"\bqrobot\.[a-z]+/\d+\b")


class Page(HTMLParser):
    """What a page fetches, links to and can be linked to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attributes}
        if "id" in found:
            self.anchors.add(found["id"])
        self.fetched += [found[name] for kind, name in LOADS if kind == tag and name in found]
        if tag == "link" and set(found.get("rel", "").split()) & {
            "stylesheet", "icon", "preload", "prefetch", "preconnect", "dns-prefetch", "manifest",
        }:  # fmt: skip
            self.fetched.append(found["href"])
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        self.fetched += re.findall(r"url\(([^)]+)\)", found.get("style", ""))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not (ROOT / "mkdocs.yml").exists():
        pytest.skip("the site is not in a wheel")
    target = tmp_path_factory.mktemp("site")
    environment = os.environ | {"QROBOT_DOCS_EXECUTE": "false", "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", target],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return target


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    found = {path: Page(path) for path in site.rglob("*.html")}
    assert len(found) > 60
    return found


def outside(address: str) -> bool:
    parts = urlsplit(address.strip("'\" "))
    return bool(parts.netloc) or parts.scheme not in {"", "data"}


@pytest.mark.slow
def test_nothing_is_fetched_from_elsewhere(site: Path, pages: dict[Path, Page]) -> None:
    for path, page in pages.items():
        assert page.fetched, path
        assert not [address for address in page.fetched if outside(address)], path
    for path in site.rglob("*.css"):
        asked = re.findall(r"url\(([^)]+)\)|@import +([^;]+)", path.read_text())
        assert not [one or other for one, other in asked if outside(one or other)], path


@pytest.mark.parametrize(
    "text", ["<script src=//a.example/x.js>", "<link rel=stylesheet href=https://a.example/x.css>"]
)
def test_an_address_elsewhere_is_found(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.html").write_text(text)
    assert [address for address in Page(tmp_path / "x.html").fetched if outside(address)]


@pytest.mark.slow
def test_links_lead_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    broken = list(broken_links(site, pages))
    assert not broken, broken[:10]


def broken_links(site: Path, pages: dict[Path, Page]) -> Iterator[str]:
    for path, page in pages.items():
        if path.name == "404.html":  # its links begin at the server's root
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            known = target in pages and (
                not parts.fragment or unquote(parts.fragment) in pages[target].anchors
            )
            if not known and not (target.is_file() and not parts.fragment):
                yield f"{path.relative_to(site)}: {link}"


@pytest.mark.slow
def test_the_reference_has_every_public_name(site: Path, pages: dict[Path, Page]) -> None:
    anchors = {
        anchor for path, page in pages.items() if "api" in path.parts for anchor in page.anchors
    }
    for name in set(qrobot.__all__) - {"__version__"}:
        assert f"qrobot.{name}" in anchors, name


@pytest.mark.slow
def test_every_check_has_its_page(site: Path) -> None:
    for name in all_checks():
        assert (site / f"notebooks/check_{name.replace('-', '_')}/index.html").exists(), name


@pytest.mark.slow
def test_measured_parts_have_a_chart(site: Path) -> None:
    page = (site / "benchmarks/index.html").read_text()
    charts = set(re.findall(r"chart-([a-z]+)-title", page))
    assert charts <= {path.stem for path in (ROOT / "benchmarks/results").glob("*.json")}
    assert len(charts) >= 9
    cvrplib = json.loads((ROOT / "benchmarks/results/cvrplib.json").read_text())["rows"]
    for row in cvrplib:
        assert f"<title>{row['instance']}: {100 * row['gap']:.2f}</title>" in page


def test_the_versions_of_the_schemas_are_those_of_the_code() -> None:
    used = {
        schema
        for folder in ("qrobot", "ansible")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in {".py", ".yml", ".json"} and ".ansible" not in path.parts
        for schema in SCHEMA.findall(path.read_text())
    }
    rows = [line for line in (ROOT / "docs/schemas.md").read_text().splitlines() if line[:1] == "|"]
    listed = [schema for row in rows for schema in SCHEMA.findall(row.split("|")[1])]
    assert len(used) >= 8
    assert sorted(listed) == sorted(used)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.mark.slow
@needs_chromium
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize(
    "page", ["", "formats", "api", "benchmarks", "glossary", "tutorial", "notebooks/check_neal"]
)
def test_a_page_fits_the_screen(
    chromium: Browser, site: Path, page: str, width: int, dark: bool
) -> None:
    chromium.open(site / page / "index.html", width, dark=dark)
    assert chromium.requests
    assert all(address.startswith(("file:", "data:")) for address in chromium.requests)
    assert chromium.ask("document.documentElement.scrollWidth") == width
    shade = chromium.ask("getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0]")
    assert (int(shade) < 128) == dark
