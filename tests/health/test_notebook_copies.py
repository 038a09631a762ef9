"""A notebook whose copy cannot be written costs its copy, and no other check."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from health.commands import code_of
from health.executed import executes

from qrobot.health import choose, read_report
from qrobot.health.notebooks import run_notebooks


@pytest.mark.slow
@executes
def test_the_other_checks_and_every_report_are_still_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "numpy.ipynb").mkdir()  # a folder cannot be replaced by a file
    path = tmp_path / "x.json"
    words = ("numpy", "dimod", "--no-system", "--notebooks", tmp_path, "--output", path)
    assert code_of(*words) == 2
    said = capsys.readouterr()
    assert "2 passed" in said.out
    (sentence,) = [line for line in said.err.splitlines() if line.startswith("qrobot: ")]
    assert "numpy.ipynb" in sentence
    assert [(c.name, c.status) for c in read_report(path).checks] == [
        ("numpy", "pass"), ("dimod", "pass"),
    ]  # fmt: skip
    assert (tmp_path / "dimod.ipynb").is_file()


@executes
def test_without_a_temporary_folder_every_check_has_its_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    results, troubles = run_notebooks(choose(["numpy", "dimod"]), tmp_path)
    assert [result.status for result in results] == ["error", "error"]
    assert "No such file or directory" in results[0].message
    assert not troubles
