"""Whatever goes wrong in a notebook is told as what it is, and kept in the executed copy."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from health.executed import error_kept, executes, outputs, run_notebook
from health.planted import CREDENTIALS
from processes import HANG, gone, until

from qrobot.errors import InputError, MissingExtraError
from qrobot.health import Check, Limits, notebooks

ROOT = Path(__file__).resolve().parents[2]

Plant = Callable[..., Check]

MODULE = """
from qrobot.health.check import Check
def answer():
{answer}

def expected():
    return [1.0]

CHECK = Check(
    module=__name__, title="planted", group="base", imports=(), distributions=("numpy",),
    source="planted",
)
"""

NOTEBOOK = """\
# %% [markdown]
# # A planted notebook

# %%
{cells}

# %%
from qrobot.health.lesson import verdict
from planted_{name} import CHECK
{last}
"""


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    folder = tmp_path / "sources"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setattr(notebooks, "FOLDERS", (folder,))

    def make(
        name: str,
        *,
        answer: str = "return [1.0]",
        cells: str = "print('a lesson')",
        last: str = "verdict(CHECK)",
        distributions: tuple[str, ...] = ("numpy",),
    ) -> Check:
        body = textwrap.indent(textwrap.dedent(answer).strip(), "    ")
        (folder / f"planted_{name}.py").write_text(MODULE.format(answer=body))
        text = NOTEBOOK.format(name=name, cells=textwrap.dedent(cells).strip(), last=last)
        (folder / f"check_planted_{name}.py").write_text(text)
        return Check(
            module=f"planted_{name}",
            title="planted",
            group="base",
            imports=(),
            distributions=distributions,
            source="planted",
        )

    return make


@pytest.mark.slow
@executes
@pytest.mark.parametrize(("wrong", "told"), [("1.1", "1.1"), ("float('nan')", "nan")])
def test_a_wrong_answer_fails_and_is_kept(
    plant: Plant, tmp_path: Path, wrong: str, told: str
) -> None:
    found = run_notebook(plant("wrong", answer=f"return [{wrong}]"), tmp_path)
    assert found.status == "fail"
    assert f"number 1 is {told}, expected is 1" in found.message
    assert error_kept(tmp_path, "planted-wrong").startswith("AssertionError: number 1")
    assert any("WRONG" in o.data["text/plain"] for o in outputs(tmp_path, "planted-wrong")[1:2])


@pytest.mark.slow
@executes
@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"cells": "1 / 0"}, "cell 2 failed: ZeroDivisionError: division by zero"),
        ({"answer": "raise ValueError('two\\nlines')"}, "cell 3 failed: ValueError: two lines"),
        ({"last": "pass"}, "it gave no verdict"),
        ({"last": "import dataclasses, sys\nsys.modules['other'] = sys.modules[CHECK.module]\n"
                  "verdict(dataclasses.replace(CHECK, module='other'))"},
         "it gave no verdict"),
        ({"last": "verdict(CHECK)\n\n# %%\nraise KeyError('late')"}, "cell 4 failed: KeyError"),
    ],
)  # fmt: skip
def test_a_notebook_without_an_answer_is_an_error(
    plant: Plant, tmp_path: Path, changes: dict[str, str], told: str
) -> None:
    found = run_notebook(plant("bad", **changes), tmp_path)
    assert found.status == "error"
    assert told in found.message
    assert (tmp_path / "planted-bad.ipynb").is_file()


@pytest.mark.slow
@executes
@pytest.mark.parametrize(
    ("crash", "told"),
    [
        ("os.kill(os.getpid(), signal.SIGILL)", "cell 3 ended the kernel by SIGILL"),
        ("ctypes.string_at(0)", "cell 3 ended the kernel by SIGSEGV"),
        ("os._exit(3)", "cell 3 ended the kernel with code 3"),
    ],
)
def test_a_dead_kernel_is_named_and_kept(
    plant: Plant, tmp_path: Path, crash: str, told: str
) -> None:
    found = run_notebook(plant("dead", answer=f"import ctypes, os, signal\n{crash}"), tmp_path)
    assert found.status == "error"
    assert found.message == f"{told}; see {tmp_path / 'planted-dead.ipynb'}"
    assert error_kept(tmp_path, "planted-dead") == f"KernelError: {told}"
    assert any("a lesson" in o.get("text", "") for o in outputs(tmp_path, "planted-dead"))


@executes
def test_a_kernel_that_does_not_start_is_told(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ipykernel_launcher.py").write_text("raise SystemExit('no licence')")
    monkeypatch.syspath_prepend(str(tmp_path))
    found = run_notebook(plant("lame"), tmp_path)
    assert found.status == "error"
    assert found.message.startswith("the kernel did not start: no licence")


HANGS = "import time\nwhile True: time.sleep(60)"
HOG = "held = []\nwhile True: held.append(b'x' * 2**24); time.sleep(0.02)"


@executes
def test_too_much_memory_ends_the_notebook(plant: Plant, tmp_path: Path) -> None:
    limits = Limits(seconds=HANG, megabytes=300)
    found = run_notebook(plant("greedy", answer=f"import time\n{HOG}"), tmp_path, limits)
    assert found.status == "error"
    told = "took more than 300 MB of memory"
    assert told in found.message
    assert told in error_kept(tmp_path, "planted-greedy")


@executes
def test_too_long_a_time_ends_the_notebook(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The clock goes on when the cell runs, however long the kernel took to start."""
    began = tmp_path / "began"
    clock = SimpleNamespace(monotonic=lambda: 901.0 if began.exists() else 0.0)
    monkeypatch.setattr(notebooks, "time", clock)
    answer = f"open({str(began)!r}, 'w').close()\n{HANGS}"
    found = run_notebook(plant("slow", answer=answer), tmp_path, Limits(seconds=900))
    assert found.status == "error"
    told = "took longer than 900 s and was stopped"
    assert told in found.message
    assert told in error_kept(tmp_path, "planted-slow")


@executes
def test_a_stack_that_is_absent_is_not_run(plant: Plant, tmp_path: Path) -> None:
    check = plant("absent", cells="1 / 0", distributions=("numpy", "qrobot-no-such-thing"))
    found = run_notebook(check, tmp_path)
    assert found.status == "absent"
    assert "qrobot-no-such-thing not installed" in found.message
    assert not (tmp_path / "planted-absent.ipynb").exists()


@executes
def test_the_kernel_is_this_python_alone_and_without_secrets(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in CREDENTIALS:
        monkeypatch.setenv(name, "pl4nted-0123456789")
    spec = tmp_path / "share" / "kernels" / "python3"  # another kernel of the same name
    spec.mkdir(parents=True)
    other = {"argv": ["/bin/false"], "display_name": "other", "language": "python"}
    (spec / "kernel.json").write_text(json.dumps(other))
    monkeypatch.setenv("JUPYTER_PATH", str(spec.parents[1]))
    answer = f"""
        import os, pathlib, sys, psutil
        assert sys.executable == {sys.executable!r}, sys.executable
        assert not [name for name, value in os.environ.items() if "pl4nted" in value]
        assert os.path.samefile(os.environ["TMPDIR"], pathlib.Path.cwd())
        doors = psutil.Process().net_connections(kind="inet")
        assert {{door.laddr.ip for door in doors}} <= {{"127.0.0.1"}}, doors
        assert not pathlib.Path.cwd().is_relative_to({str(ROOT)!r})
        return [1.0]
    """
    found = run_notebook(plant("inside", answer=answer), tmp_path)
    assert found.status == "pass", found.message


@executes
@pytest.mark.parametrize("own_session", [False, True])
def test_processes_that_a_notebook_left_are_ended(
    plant: Plant, tmp_path: Path, own_session: bool
) -> None:
    note = tmp_path / "pid"
    answer = f"""
        import pathlib, subprocess
        child = subprocess.Popen(["sleep", "600"], start_new_session={own_session})
        pathlib.Path({str(note)!r}).write_text(str(child.pid))
        return [1.0]
    """
    assert run_notebook(plant("parent", answer=answer), tmp_path).status == "pass"
    assert gone(int(note.read_text()))


SCRIPT = """
import sys
from pathlib import Path
from planted_long import CHECK
from qrobot.health import notebooks
notebooks.FOLDERS = (Path(sys.argv[1]),)
notebooks.run_notebooks([CHECK], Path(sys.argv[2]))
"""


@executes
def test_ctrl_c_ends_the_kernel_too(plant: Plant, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    answer = (
        f"import os, pathlib\npathlib.Path({str(note)!r}).write_text(str(os.getpid()))\n{HANGS}"
    )
    plant("long", answer=answer)
    folder = tmp_path / "sources"
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, folder, tmp_path],
        env={"PYTHONPATH": f"{folder}:{ROOT}", "HOME": str(tmp_path), "PATH": "/usr/bin:/bin"},
        stderr=subprocess.PIPE,
    )
    until(lambda: (note.exists() and note.read_text()) or process.poll() is not None, "no note")
    process.send_signal(signal.SIGINT)
    _, words = process.communicate()
    assert words.rstrip().endswith(b"KeyboardInterrupt")
    assert gone(int(note.read_text()))


@executes
def test_a_folder_that_cannot_be_written_is_refused_first(plant: Plant, tmp_path: Path) -> None:
    check = plant("never", cells="1 / 0")
    file = tmp_path / "file"
    file.write_text("mine")
    for folder in (file, file / "deeper", Path("/proc/qrobot")):
        with pytest.raises(InputError, match="cannot be written") as caught:
            run_notebook(check, folder)
        assert caught.value.field == "--notebooks"
    assert file.read_text() == "mine"


@executes
def test_an_older_copy_stays_when_the_new_one_cannot_be_written(
    plant: Plant, tmp_path: Path
) -> None:
    (tmp_path / "planted-there.ipynb").mkdir()  # a folder cannot be replaced by a file
    with pytest.raises(InputError, match="planted-there"):
        run_notebook(plant("there"), tmp_path)
    assert not list(tmp_path.glob(".qrobot-*"))


def test_missing_tools_name_their_extra(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebooks, "TOOLS", ("qrobot_no_such_tool",))
    with pytest.raises(MissingExtraError, match=r"pip install 'qrobot\[lab\]'"):
        run_notebook(plant("tools"), Path("nowhere"))
    assert not Path("nowhere").exists()


def test_a_check_without_its_notebook_is_told(plant: Plant, tmp_path: Path) -> None:
    check = plant("lost")
    (tmp_path / "sources" / "check_planted_lost.py").unlink()
    with pytest.raises(InputError, match=r"no notebook check_planted_lost\.py"):
        run_notebook(check, tmp_path)
