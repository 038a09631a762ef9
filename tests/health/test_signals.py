"""A polite kill of the command ends its checks and all that they started, as Ctrl-C does."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from health.planted import Plant, left_behind, planter
from processes import gone, until

COMMAND = """
import sys
import planted_long
import qrobot.health
from qrobot.cli import main
qrobot.health.choose = lambda *_, **__: [planted_long.CHECK]
main(["health", "--no-system", *sys.argv[1:]])
"""


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    return planter(tmp_path, monkeypatch)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, 130)]
)
def test_a_polite_kill_of_the_command_leaves_nothing_behind(
    plant: Plant, tmp_path: Path, number: signal.Signals, code: int
) -> None:
    notes = [tmp_path / "pid", tmp_path / "child"]
    body = f"""
        import os, pathlib, subprocess, time
        child = subprocess.Popen(["sleep", "600"], start_new_session=True)
        pathlib.Path({str(notes[1])!r}).write_text(str(child.pid))
        pathlib.Path({str(notes[0])!r}).write_text(str(os.getpid()))
        time.sleep(600)
    """
    plant("long", body)
    runner, folder = command(tmp_path)
    await_notes(runner, notes)
    assert left_behind(folder)
    runner.send_signal(number)
    if number != signal.SIGINT:  # of which a second one ends it as usual
        runner.send_signal(number)
    assert runner.wait() == code
    assert all(gone(int(note.read_text())) for note in notes)
    assert left_behind(folder) == []


def test_a_hangup_that_is_ignored_stays_ignored(plant: Plant, tmp_path: Path) -> None:
    note, gate = tmp_path / "pid", tmp_path / "gate"
    body = f"""
        import pathlib, time
        pathlib.Path({str(note)!r}).write_text("began")
        while not pathlib.Path({str(gate)!r}).exists():
            time.sleep(0.05)
        return [1.0]
    """
    plant("long", body)
    runner, _ = command(tmp_path, before="signal.signal(signal.SIGHUP, signal.SIG_IGN)")
    await_notes(runner, [note])
    runner.send_signal(signal.SIGHUP)
    gate.touch()
    assert runner.wait() == 0


def command(folder: Path, *, before: str = "") -> tuple[subprocess.Popen[bytes], Path]:
    """Start ``qrobot health`` on the planted check, and return it and its folder for folders."""
    temporary = folder / "temporary"
    temporary.mkdir()
    paths = os.pathsep.join([str(folder), *filter(None, sys.path)])
    # In the background SIGINT may be ignored, under nohup SIGHUP.
    usual = "signal.signal(signal.SIGINT, signal.default_int_handler)"
    usual += "; signal.signal(signal.SIGHUP, signal.SIG_DFL)"
    runner = subprocess.Popen(
        [sys.executable, "-c", f"import signal; {usual}\n{before}\n{COMMAND}"],
        env=os.environ | {"PYTHONPATH": paths, "TMPDIR": str(temporary)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return runner, temporary


def await_notes(runner: subprocess.Popen[bytes], notes: list[Path]) -> None:
    def written() -> bool:
        assert runner.poll() is None
        return all(note.exists() and note.read_text() for note in notes)

    until(written, "no notes")
