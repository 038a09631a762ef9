"""One check in its process: its figures, its crashes by name, what it sees and what it cannot."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from health.planted import CREDENTIALS, Plant, planter
from jobs.homeless import homeless

from qrobot.health import Limits, all_checks, run


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    return planter(tmp_path, monkeypatch)


def test_a_right_answer_passes_with_all_its_figures(plant: Plant) -> None:
    found = run(plant("fine", "return [1.0]", imports=("json",)))
    assert found.status == "pass"
    assert found.answer == found.expected == (1.0,)
    assert set(found.versions) == {"numpy"}
    assert found.import_seconds is not None
    assert found.import_seconds >= 0
    assert found.run_seconds is not None
    assert found.run_seconds >= 0
    assert found.peak_mb is not None
    assert found.peak_mb > 5


@pytest.mark.parametrize(("wrong", "told"), [("1.1", "1.1"), ("float('nan')", "nan")])
def test_a_wrong_answer_fails(plant: Plant, wrong: str, told: str) -> None:
    found = run(plant("wrong", f"return [{wrong}]"))
    assert found.status == "fail"
    assert f"number 1 is {told}, expected is 1" in found.message


def test_watching_the_memory_does_not_take_the_processor(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate, clock, looks = tmp_path / "gate", [0.0], []

    def sleep(seconds: float) -> None:
        clock[0] += seconds
        time.sleep(0.001)
        if clock[0] > 2.0:
            gate.touch()

    def slow(_: int) -> float:  # as /proc is on an emulated machine
        clock[0] += 0.05
        looks.append(0.05)
        return 1.0

    monkeypatch.setattr(
        "qrobot.health.process.time", SimpleNamespace(monotonic=lambda: clock[0], sleep=sleep)
    )
    monkeypatch.setattr("qrobot.health.process.resident_memory", slow)
    body = f"import os, time\nwhile not os.path.exists({str(gate)!r}): time.sleep(0.01)"
    limits = Limits(seconds=1e9)
    assert run(plant("long", f"{body}\nreturn [1.0]"), limits).status == "pass"
    assert looks
    assert sum(looks) < 0.2 * clock[0]


def test_the_memory_is_that_of_the_check(plant: Plant) -> None:
    ballast = bytearray(os.urandom(1)) * (200 * 2**20)  # ours, which fork must not count
    found = run(plant("small", "return [1.0]"))
    assert found.peak_mb is not None
    assert found.peak_mb < 150
    assert len(ballast) > 0


CRASHES = {
    "segfault": ("import ctypes; ctypes.string_at(0)", "SIGSEGV"),
    "illegal": ("import os, signal; os.kill(os.getpid(), signal.SIGILL)", "SIGILL"),
    "bus": ("import os, signal; os.kill(os.getpid(), signal.SIGBUS)", "SIGBUS"),
    "abort": ("import os; os.abort()", "SIGABRT"),
    "killed": ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "SIGKILL"),
    "exit": ("import os; os._exit(3)", "code 3"),
    "quiet exit": ("import sys; sys.exit(0)", "code 0"),
    "words": ("import sys; sys.exit('no licence')", "code 1: no licence"),
    "exception": ("raise ValueError('two\\nlines')", "ValueError: two lines"),
    "memory error": ("bytearray(2**60)", "out of memory"),
}


@pytest.mark.parametrize("crash", CRASHES)
def test_a_crash_of_the_computation_is_named(plant: Plant, crash: str) -> None:
    body, told = CRASHES[crash]
    found = run(plant("crash", body))
    assert found.status == "error"
    assert "its computation" in found.message
    assert told in found.message
    assert found.import_seconds is not None
    assert found.run_seconds is None
    assert found.answer is None


def test_a_crash_of_the_import_is_told_apart(plant: Plant, tmp_path: Path) -> None:
    (tmp_path / "planted_wheel.py").write_text("import os, signal\nos.kill(os.getpid(), 4)\n")
    found = run(plant("import", "return [1.0]", imports=("planted_wheel",)))
    assert found.status == "error"
    assert found.message == "its import was ended by SIGILL"
    assert found.import_seconds is None


def test_a_crash_after_the_answer_is_no_pass(plant: Plant) -> None:
    body = "import atexit, os\natexit.register(os.abort)\nreturn [1.0]"
    found = run(plant("late", body))
    assert found.status == "error"
    assert found.message == "its end was ended by SIGABRT"
    assert found.answer == (1.0,)


def test_a_long_answer_is_no_hang(plant: Plant) -> None:
    found = run(plant("long", "return [1.5] * 10**5"))
    assert found.status == "fail"
    assert found.message == "the answer has 100000 numbers, expected are 1"


def test_noise_of_an_sdk_harms_nothing(plant: Plant) -> None:
    body = """
        import os
        for stream in (1, 2):
            for _ in range(20):
                os.write(stream, b'{"answer": [7]}\\n' * 2**12)
        return [1.0]
    """
    assert run(plant("noise", body)).status == "pass"


def test_no_credential_reaches_a_check(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in CREDENTIALS:
        monkeypatch.setenv(name, "pl4nted-0123456789")
    body = """
        import os
        assert os.environ["LANG"] == "C.UTF-8"
        return [1.0 - sum("pl4nted" in value for value in os.environ.values())]
    """
    monkeypatch.setenv("LANG", "C.UTF-8")
    found = run(plant("secret", body))
    assert found.status == "pass", found.message


def test_the_current_folder_hides_no_stack(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "numpy.py").write_text("raise RuntimeError\n")
    monkeypatch.chdir(folder)
    assert run(plant("shadow", "return [1.0]", imports=("numpy",))).status == "pass"


def test_a_user_without_a_home_has_results(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    homeless(monkeypatch)
    found = run(plant("homeless", "return [1.0]"))
    assert (found.status, found.message) == ("pass", "planted")


def test_the_jupyter_check_bears_a_long_way_to_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = all_checks()["jupyter"]
    absent = set(check.distributions) - set(check.versions())
    if absent:
        pytest.skip(f"{', '.join(sorted(absent))} not installed")
    folder = tmp_path / ("x" * 100)
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    found = run(check)
    assert found.status == "pass", found.message
