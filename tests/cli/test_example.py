"""``qrobot solve example``: something to try where nothing else is at hand."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from click.testing import CliRunner

from qrobot.cli.progress import ProgressLine
from qrobot.cli.solve import command
from qrobot.errors import InputError
from qrobot.planning import Progress
from qrobot.problem.formats import example_path, read, suffixes

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_every_example_has_its_name() -> None:
    assert read("example") == read(EXAMPLES / "small-warehouse.json")
    files = [file for suffix in suffixes() for file in EXAMPLES.glob(f"*{suffix}")]
    for file in files:
        if file.stem != "layout" and "." not in file.stem:  # what lies beside another file
            assert example_path(f"example:{file.stem}") == file


def test_a_file_of_that_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("example").write_text("mine")
    with pytest.raises(InputError, match="unsupported format"):
        read("example")


@pytest.mark.parametrize("name", ["example:nothing", "example:", "example:../pyproject"])
def test_an_unknown_one_names_those_there_are(name: str) -> None:
    with pytest.raises(InputError, match=r"no such example; use one of .*example:three-items"):
        read(name)


def test_the_command_takes_it() -> None:
    done = CliRunner().invoke(command, ["example:three-items", "-b", "exact"], prog_name="solve")
    assert done.exit_code == 0, done.output
    assert "proven optimal" in done.output


def test_the_first_plan_is_told_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not only when the next line is due."""
    monkeypatch.setattr("qrobot.cli.progress.PLAIN", 3600.0)
    line = ProgressLine()
    line.live = False
    thread = threading.Thread(target=line.show, daemon=True)
    thread.start()
    line(Progress("exact", 0.1, None, 0.0))
    line(Progress("exact", 0.2, 12.0, 0.0))
    for _ in range(1000):
        if "12" in (seen := capsys.readouterr().err):
            break
        thread.join(0.01)
    else:
        pytest.fail("nothing was told")
    assert "exact: distance 12" in seen
    line.end()
    thread.join(10)
    assert not thread.is_alive()
