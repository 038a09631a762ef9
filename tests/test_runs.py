"""What a run of the tests prints, and what it does about processes that are left behind."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent

SOME = """
import subprocess, sys
import pytest

@pytest.mark.parametrize("k", range(30))
def test_absent(k):
    pytest.skip("qiskit is not installed: pip install 'qrobot[qiskit]'")

@pytest.mark.parametrize("k", range(4))
def test_other(k, subtests):
    with subtests.test("part"):
        pytest.skip("no docker")
    with subtests.test("whole"):
        assert True

def test_wrong():
    assert 1 == 2
"""

LEFT = """
import subprocess
import pytest

KEPT = []

def start():
    child = subprocess.Popen(["sleep", "1000"])
    KEPT.append(child)
    print("pid", child.pid)
    return child

@pytest.fixture(scope="module")
def server():
    child = start()
    yield child
    child.kill()
    child.wait()

def test_shares(server):
    assert server.poll() is None

def test_ends():
    child = start()
    child.kill()
    child.wait()

def test_fails():
    start()
    raise ValueError("and leaves a child")

def test_leaves():
    start()
"""


def run(folder: Path, source: str, *options: str) -> tuple[int, list[str]]:
    """Run tests of a folder of their own with the settings of ours."""
    (folder / "conftest.py").write_text((HERE / "conftest.py").read_text())
    (folder / "test_some.py").write_text(source)
    done = subprocess.run(
        [
            sys.executable, "-m", "pytest", "-c", ROOT / "pyproject.toml", "--rootdir", folder,
            "-p", "no:cacheprovider", "--confcutdir", folder, "-o", f"pythonpath={HERE}",
            *options, folder,
        ],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout.splitlines()


@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_skipped_tests_are_one_line_and_failures_are_last(
    workers: tuple[str, ...], tmp_path: Path
) -> None:
    code, lines = run(tmp_path, SOME, "-q", *workers)
    assert code == 1
    (skipped,) = [line for line in lines if "qiskit" in line]
    assert skipped == "34 skipped: 30 qiskit is not installed; 4 no docker"
    last = [line for line in lines[lines.index(skipped) + 1 :] if not line.startswith("=")]
    assert [line.split(" - ")[0].split(" in ")[0] for line in last] == [
        "FAILED test_some.py::test_wrong",
        "1 failed, 4 passed, 34 skipped, 4 subtests passed",
    ]


def test_a_test_that_leaves_a_process_fails_and_the_process_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("QROBOT_TEST_PATIENCE", "0.1")
    code, lines = run(tmp_path, LEFT, "-q", "-s")
    assert code == 1
    failed = [line.split(" - ")[0] for line in lines if line.startswith(("FAILED", "ERROR"))]
    assert failed == ["FAILED test_some.py::test_fails", "ERROR test_some.py::test_leaves"]
    pids = [int(word) for line in lines for word in line.split("pid ")[1:]]
    assert len(pids) == 4
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)
