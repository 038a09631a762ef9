"""Whatever a check does, the result says so, and the checks beside it are unharmed."""

from __future__ import annotations

import json
import os
import textwrap
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from click.testing import CliRunner

import qrobot.health
from qrobot.cli.health import command
from qrobot.health import Check, Limits, run

Plant = Callable[..., Check]

SOURCE = """
from qrobot.health.check import Check
{top}
def answer():
{body}

CHECK = Check(
    module=__name__, title="planted", group="base", imports={imports!r},
    distributions={distributions!r}, answer=answer, expected=lambda: [1.0], source="planted",
)
"""


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(
        name: str,
        body: str,
        *,
        top: str = "",
        imports: tuple[str, ...] = (),
        distributions: tuple[str, ...] = ("numpy",),
    ) -> Check:
        source = SOURCE.format(
            top=top,
            body=textwrap.indent(textwrap.dedent(body).strip(), "    "),
            imports=imports,
            distributions=distributions,
        )
        (tmp_path / f"planted_{name}.py").write_text(source)
        return Check(
            module=f"planted_{name}",
            title="planted",
            group="base",
            imports=imports,
            distributions=distributions,
            answer=list,  # what counts is the file
            expected=list,
            source="planted",
        )

    return make


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


HOG = """
import time
held = []
for _ in range(25):
    held.append(b"x" * 2**24)
    time.sleep(0.01)
time.sleep(600)
"""


def test_a_run_goes_on_whatever_one_check_does(
    plant: Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    planted = [
        plant("first", "return [1.0]"),
        plant("segfault", CRASHES["segfault"][0]),
        plant("illegal", CRASHES["illegal"][0]),
        plant("hang", "import time\nwhile True: time.sleep(60)"),
        plant("hog", HOG),
        plant("missing", "return [1.0]", distributions=("numpy", "qrobot-no-such-thing")),
        plant("wrong", "return [2.0]"),
        plant("last", "return [1.0]"),
    ]
    special = {"planted-hang": Limits(seconds=2), "planted-hog": Limits(megabytes=200)}
    monkeypatch.setattr(qrobot.health, "choose", lambda names, quick: planted)
    monkeypatch.setattr(
        qrobot.health, "run", lambda check, limits: run(check, special.get(check.name, limits))
    )
    done = CliRunner().invoke(command, ["--json"])
    assert done.exit_code == 1
    checks = {check["name"]: check for check in json.loads(done.stdout)["checks"]}
    assert {name: check["status"] for name, check in checks.items()} == {
        "planted-first": "pass",
        "planted-segfault": "error",
        "planted-illegal": "error",
        "planted-hang": "error",
        "planted-hog": "error",
        "planted-missing": "absent",
        "planted-wrong": "fail",
        "planted-last": "pass",
    }
    assert "took longer than 2 s and was stopped" in checks["planted-hang"]["message"]
    memory = "its computation took more than 200 MB of memory and was stopped"
    assert checks["planted-hog"]["message"] == memory
    assert checks["planted-hog"]["peak_mb"] > 200
    assert "qrobot-no-such-thing not installed" in checks["planted-missing"]["message"]
    assert checks["planted-missing"]["peak_mb"] is None


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


def test_a_broken_wheel_is_an_error_and_no_absence(plant: Plant) -> None:
    found = run(plant("broken", "return [1.0]", imports=("numpy.no_such_part",)))
    assert found.status == "error"
    assert "its import failed: ModuleNotFoundError" in found.message
    assert "numpy" in found.versions


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


def test_processes_that_a_check_left_are_ended(plant: Plant, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    body = f"""
        import pathlib, subprocess
        child = subprocess.Popen(["sleep", "600"])
        pathlib.Path({str(note)!r}).write_text(str(child.pid))
        child.returncode = 0  # no word at the end that it still runs
        return [1.0]
    """
    assert run(plant("parent", body)).status == "pass"
    try:
        left = psutil.Process(int(note.read_text()))
        if left.status() != psutil.STATUS_ZOMBIE:  # where nobody collects the dead
            left.wait(timeout=30)
    except psutil.NoSuchProcess:
        pass


def test_no_credential_reaches_a_check(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DWAVE_API_TOKEN", "DEV-0123456789")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "0123456789")
    body = """
        import os
        hidden = not {"DWAVE_API_TOKEN", "AWS_SECRET_ACCESS_KEY"} & set(os.environ)
        return [float(hidden)]
    """
    assert run(plant("secret", body)).status == "pass"


def test_the_current_folder_hides_no_stack(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "numpy.py").write_text("raise RuntimeError\n")
    monkeypatch.chdir(folder)
    assert run(plant("shadow", "return [1.0]", imports=("numpy",))).status == "pass"
