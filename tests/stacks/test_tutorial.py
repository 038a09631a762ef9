"""The tutorial runs, as a notebook, and its own assertions hold."""

from __future__ import annotations

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from stacks.stacks import needs

ROOT = Path(__file__).parents[2]


@needs("qiskit")
def test_the_tutorial_runs_as_a_notebook(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="make setup installs the notebook tools")
    pytest.importorskip("l2m4m", reason="make setup installs what renders a page")
    target = tmp_path / "tutorial.ipynb"
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "run_tutorial.py", target],
        capture_output=True, text=True, cwd=tmp_path, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    cells = nbformat.read(target, as_version=4).cells
    code = [cell for cell in cells if cell.cell_type == "code"]
    assert code
    assert all(cell.execution_count for cell in code)
    pictures = [o for cell in code for o in cell.outputs if "image/png" in o.get("data", {})]
    assert len(pictures) == 2
    text = "".join(o.get("text", "") for cell in code for o in cell.outputs)
    assert "proven optimal" in text
    check_page(target.with_suffix(".html").read_text(), cells)


def check_page(page: str, cells: list[Any]) -> None:
    """The page holds every heading, cell and picture, and nothing that is fetched."""
    reader = PageReader()
    reader.feed(page)
    headings = [line[2:] for c in cells if c.cell_type == "markdown"
                for line in c.source.splitlines() if line.startswith("# ")]  # fmt: skip
    assert headings
    assert all(heading in reader.text for heading in headings)
    for cell in cells:
        if cell.cell_type == "code":
            assert "".join(cell.source.split()) in "".join(reader.text.split())
    assert len(reader.pictures) == 2
    assert all(picture.startswith("data:image/png;base64,") for picture in reader.pictures)
    assert not reader.fetched


class PageReader(HTMLParser):
    """What a browser would show and fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""
        self.pictures: list[str] = []
        self.fetched: list[str] = []

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        source = dict(attrs).get("src") or ""
        if tag == "img":
            self.pictures.append(source)
        elif source or tag == "link":
            self.fetched.append(source or tag)
