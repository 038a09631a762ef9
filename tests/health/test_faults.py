"""Planted faults, real ones: each is told as what it is, and the checks beside it are unharmed."""

from __future__ import annotations

import os
import platform
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest
from health.planted import Plant, left_behind, planter
from processes import HANG, gone, until

from qrobot.health import Check, CheckResult, Limits, process, run, run_all

SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")

HOG = """
import time
held = []
for _ in range(25):
    held.append(b"x" * 2**24)
    time.sleep(0.01)
time.sleep(600)
"""

FLOOD = """
import os
for _ in range(500):
    os.write(1, b"x" * 65536)
    os.write(2, b'{"answer": [7]}\\n' * 4096)
return [1.0]
"""

ILLEGAL = """
import ctypes, mmap
page = mmap.mmap(-1, mmap.PAGESIZE, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
page.write(b"\\x0f\\x0b" * 2 if {x86} else bytes(4))  # ud2, udf
ctypes.CFUNCTYPE(None)(ctypes.addressof(ctypes.c_char.from_buffer(page)))()
""".replace("{x86}", str(platform.machine() in ("x86_64", "i686")))
"""An instruction that no processor of this kind has, executed."""


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    return planter(tmp_path, monkeypatch)


@pytest.mark.parametrize("jobs", [1, 3])
def test_a_run_goes_on_whatever_one_check_does(plant: Plant, tmp_path: Path, jobs: int) -> None:
    (tmp_path / f"planted_wheel{SUFFIX}").write_bytes(b"garbage" * 99)
    faults = {
        "first": plant("first", "return [1.0]"),
        "segfault": plant("segfault", "import ctypes; ctypes.string_at(0)"),
        "illegal": plant("illegal", ILLEGAL),
        "hog": plant("hog", HOG),
        "missing": plant("missing", "return [1.0]", distributions=("numpy", "qrobot-no-such")),
        "wheel": plant("wheel", "return [1.0]", imports=("planted_wheel",)),
        "wrong": plant("wrong", "return [2.0]"),
        "flood": plant("flood", FLOOD),
        "last": plant("last", "return [1.0]"),
    }
    begun: list[str] = []
    results = run_all(
        list(faults.values()),
        Limits(seconds=HANG, megabytes=200),
        jobs=jobs,
        progress=lambda check: begun.append(check.name),
    )
    assert [result.name for result in results] == begun
    assert begun == [f"planted-{name}" for name in faults]
    found = dict(zip(faults, results, strict=True))
    assert {name: result.status for name, result in found.items()} == {
        "first": "pass",
        "segfault": "error",
        "illegal": "error",
        "hog": "error",
        "missing": "absent",
        "wheel": "error",
        "wrong": "fail",
        "flood": "pass",
        "last": "pass",
    }
    assert found["segfault"].message == "its computation was ended by SIGSEGV"
    assert found["illegal"].message == "its computation was ended by SIGILL"
    memory = "its computation took more than 200 MB of memory and was stopped"
    assert found["hog"].message == memory
    assert (found["hog"].peak_mb or 0) > 200
    assert "qrobot-no-such not installed" in found["missing"].message
    assert found["missing"].peak_mb is None
    assert "is damaged" in found["wheel"].message


def test_a_check_that_hangs_is_stopped(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The clock goes on when the check computes, however long it took to start."""
    began = tmp_path / "began"
    clock = SimpleNamespace(monotonic=lambda: 901.0 if began.exists() else 0.0, sleep=time.sleep)
    monkeypatch.setattr(process, "time", clock)
    body = f"import time\nopen({str(began)!r}, 'w').close()\nwhile True: time.sleep(60)"
    found = run(plant("hang", body), Limits(seconds=900))
    assert found.status == "error"
    assert found.message == "its computation took longer than 900 s and was stopped"


def test_a_part_that_is_missing_is_an_error_and_no_absence(plant: Plant) -> None:
    found = run(plant("broken", "return [1.0]", imports=("numpy.no_such_part",)))
    assert found.status == "error"
    assert "its import failed: ModuleNotFoundError" in found.message
    assert "numpy" in found.versions


def other_machine(library: bytes) -> bytes:
    """Write another machine into an ELF header."""
    number = 183 if platform.machine() != "aarch64" else 62
    return library[:18] + number.to_bytes(2, sys.byteorder) + library[20:]


@pytest.mark.skipif(sys.platform != "linux", reason="the ELF format is Linux's")
@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize(
    ("fault", "told"),
    [
        (lambda library: library[:3], "is damaged: reinstall its package"),
        (lambda library: b"", "is damaged: reinstall its package"),
        (lambda library: bytes(len(library)), "is damaged: reinstall its package"),
        (other_machine, f"this is {platform.machine()}: reinstall"),
    ],
)
def test_a_broken_wheel_is_named(
    plant: Plant, tmp_path: Path, fault: object, told: str, wrapped: bool
) -> None:
    assert callable(fault)
    check, library = broken_package(plant, tmp_path, wrapped=wrapped)
    assert run(check).status == "pass"  # so what follows is the fault's doing
    library.write_bytes(fault(library.read_bytes()))
    found = run(check)
    assert found.status == "error"
    assert found.message.startswith("its import failed: ImportError: ")
    assert told in found.message


@pytest.mark.skipif(sys.platform != "linux", reason="the ELF format is Linux's")
def test_a_wheel_that_ends_in_the_middle_is_no_end_of_the_run(plant: Plant, tmp_path: Path) -> None:
    check, library = broken_package(plant, tmp_path, wrapped=False)
    whole = library.read_bytes()
    # Before the code ends (behind it are symbols that nobody needs): the process dies there.
    library.write_bytes(whole[:8192])
    found = run(check)
    assert found.status == "error"
    assert found.message.startswith("its import ")


def broken_package(plant: Plant, folder: Path, *, wrapped: bool) -> tuple[Check, Path]:
    """Return a check of a package of ours around a real library, and the library."""
    source = Path(psutil._psplatform.cext.__file__)  # links to nothing of its own package
    module = source.name.partition(".")[0]
    package = folder / "planted_package"
    package.mkdir()
    statement = f"import planted_package.{module}"
    if wrapped:  # as numpy and others do
        statement = f"try: {statement}\nexcept ImportError as e: raise ImportError('Oh!') from e"
    (package / "__init__.py").write_text(statement)
    shutil.copy(source, package / source.name)
    check = plant(
        "library", "return [1.0]", imports=("planted_package",), distributions=("psutil",)
    )
    return check, package / source.name


@pytest.mark.parametrize("own_session", [False, True])
def test_processes_that_a_check_left_are_ended(
    plant: Plant, tmp_path: Path, own_session: bool
) -> None:
    note = tmp_path / "pid"
    body = f"""
        import os, pathlib, time
        if os.fork() == 0:
            if {own_session}:
                os.setsid()
            if os.fork() == 0:  # whose parent dies at once
                pathlib.Path({str(note)!r}).write_text(str(os.getpid()))
                time.sleep(600)
            os._exit(0)
        note = pathlib.Path({str(note)!r})
        while not note.exists() or not note.read_text():
            time.sleep(0.01)
        return [1.0]
    """
    assert run(plant("parent", body)).status == "pass"
    assert gone(int(note.read_text()))


def test_an_interrupt_ends_all_of_them_and_is_raised(plant: Plant, tmp_path: Path) -> None:
    body = """
        import os, pathlib, time
        pathlib.Path({note!r}).write_text(str(os.getpid()))
        time.sleep(600)
    """
    notes = [tmp_path / f"pid{k}" for k in range(2)]
    checks = [plant(f"long{k}", body.format(note=str(note))) for k, note in enumerate(notes)] + [
        plant("never", f"open({str(tmp_path / 'began')!r}, 'w')")
    ]

    def interrupt() -> None:
        until(lambda: all(note.exists() and note.read_text() for note in notes), "no notes")
        os.kill(os.getpid(), signal.SIGINT)

    usual = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background
    helper = threading.Thread(target=interrupt)
    helper.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            run_all(checks, jobs=2)
    finally:
        signal.signal(signal.SIGINT, usual)
    helper.join()
    assert all(gone(int(note.read_text())) for note in notes)
    assert not (tmp_path / "began").exists()


def test_checks_die_with_who_ran_them(plant: Plant, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    body = f"""
        import os, pathlib, time
        pathlib.Path({str(note)!r}).write_text(str(os.getpid()))
        time.sleep(600)
    """
    plant("orphan", body)
    code = (
        "import planted_orphan; from qrobot.health import run_all; run_all([planted_orphan.CHECK])"
    )
    paths = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    seen = os.environ | {"PYTHONPATH": paths, "TMPDIR": str(tmp_path)}  # a killed one tidies not
    runner = subprocess.Popen([sys.executable, "-c", code], env=seen)
    until(lambda: (note.exists() and note.read_text()) or runner.poll() is not None, "no note")
    runner.kill()
    runner.wait()
    assert gone(int(note.read_text()))


def test_a_kill_by_a_full_machine_is_told_from_another(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counter = tmp_path / "vmstat"
    monkeypatch.setattr("qrobot.health.process.VMSTAT", counter)
    body = f"""
        import os, pathlib
        {{more}}pathlib.Path({str(counter)!r}).write_text("pgfault 9\\noom_kill 4\\n")
        os.kill(os.getpid(), 9)
    """
    told = []
    for more in ("0 and ", ""):
        counter.write_text("pgfault 7\noom_kill 3\n")
        found = run(plant(f"killed{len(told)}", body.format(more=more)))
        assert found.status == "error"
        told.append(found.message)
    assert told[0] == "its computation was ended by SIGKILL (perhaps the machine is out of memory)"
    assert told[1] == (
        "its computation was ended by SIGKILL (the machine ran out of memory and killed processes)"
    )


def test_no_room_for_a_folder_is_an_error_that_says_so(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    found = run(plant("homeless", "return [1.0]"))
    assert found.status == "error"
    assert "no temporary folder can be made for it (No such file or directory)" in found.message
    assert "TMPDIR" in found.message


def settings(plant: Plant, *names: str) -> CheckResult:
    """Run a check that passes when these variables name folders of its own, and it is in there."""
    body = f"""
        import os, tempfile
        own = os.environ["TMPDIR"]
        inside = [os.path.commonpath([own, os.environ[name]]) == own for name in {names!r}]
        open("a file", "w").close()
        return [float(all(inside) and os.path.samefile(os.getcwd(), own) == 1)]
    """
    return run(plant("settings", body))


def test_a_check_has_a_folder_of_its_own_that_is_deleted(
    plant: Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, home = tmp_path / "temporary", tmp_path / "home"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("HOME", str(home))
    for name in ("MPLCONFIGDIR", "IPYTHONDIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    private = ("MPLCONFIGDIR", "IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR")
    assert settings(plant, *private).status == "pass"
    # A home that takes files keeps numba's machine code: nothing is said about caches.
    assert "KeyError" in settings(plant, "NUMBA_CACHE_DIR").message
    home.write_text("a file, so nothing can be in it")
    assert settings(plant, *private, "NUMBA_CACHE_DIR", "XDG_CACHE_HOME").status == "pass"
    assert left_behind(folder) == []
    # What the user chose stays.
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert settings(plant, *private, "NUMBA_CACHE_DIR").status == "fail"
    assert left_behind(folder) == []


def test_fewer_than_one_at_once_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot run 0 checks at once"):
        run_all([], jobs=0)
