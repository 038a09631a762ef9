"""A report of another machine is shown on a terminal, and never obeyed by it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from health import samples
from health.commands import code_of
from health.samples import STRANGE

from qrobot._text import printable
from qrobot.cli.health.reports import show_comparison, show_fleet, show_report
from qrobot.health.reports import compare, fleet

OTHER = replace(
    STRANGE,
    checks=(replace(STRANGE.checks[0], status="fail"), *STRANGE.checks[1:]),
    system=(replace(STRANGE.system[0], status="fault", value="else"),),
)

SHOWN = {
    "report": show_report(STRANGE, compare(STRANGE, OTHER)),
    "comparison": show_comparison(compare(STRANGE, OTHER)),
    "fleet": show_fleet(fleet([STRANGE, OTHER, replace(OTHER, host="\x1b[2Jb\n\x9b31mc")])),
}


@pytest.mark.parametrize("name", SHOWN)
def test_nothing_that_a_terminal_obeys_is_shown(name: str) -> None:
    shown = SHOWN[name]
    assert "</b>" in shown  # the strange words are there
    assert "\ufffd[31m" in shown
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f]", shown)
    shown.encode()  # no half characters


def test_a_cell_is_one_line() -> None:
    one = samples.changed(samples.report(), "numpy", status="fail", message="two\nlines\x1b[1A")
    assert "numpy: two\ufffdlines\ufffd[1A\n" in show_report(one, None)


def test_what_people_write_stays() -> None:
    words = "Zürich 東京 Ω 51.6 °C × ½ “x” 😀"
    assert printable(words) == words


@pytest.mark.parametrize("words", [["merge"], ["compare", "SELF"]])
def test_files_of_others_reach_the_terminal_harmless(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    one = samples.report("\x1b]0;owned\x07")
    one = samples.changed(one, "numpy", status="fail", message="\x1b[2J")
    path = tmp_path / "x.json"
    path.write_text(json.dumps(one.to_dict()))
    code_of(words[0], *[path for word in words[1:] if word == "SELF"], path)
    said = capsys.readouterr()
    assert "owned" in said.out
    assert "\x1b" not in said.out + said.err
    assert "\x07" not in said.out + said.err
