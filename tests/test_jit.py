"""Where compiled code is kept, and what happens when it cannot be kept."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from qrobot import _jit as jit

PROJECT = Path(__file__).resolve().parents[1]


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_folder_is_ours_alone(temporary: Path) -> None:
    folder = jit.private_folder()
    assert folder is not None
    assert folder.parent == temporary
    assert folder.stat().st_mode & 0o077 == 0
    folder.chmod(0o777)
    assert jit.private_folder() is None


def test_a_link_of_somebody_else_is_refused(temporary: Path) -> None:
    (temporary / "elsewhere").mkdir()
    (temporary / f"qrobot-numba-{os.getuid()}").symlink_to(temporary / "elsewhere")
    assert jit.private_folder() is None


def twice(x: int) -> int:
    return 2 * x


class FakeNumba:
    """numba, with a cache that works only from a given number of folders on."""

    def __init__(self, folders: int, place: Path) -> None:
        self.place = place
        self.config = SimpleNamespace(CACHE_DIR="")
        self.folders = folders
        self.kept: list[bool] = []

    def njit(self, *, cache: bool, **_: Any) -> Any:
        if cache:
            self.folders -= 1
            if self.folders < 0:
                raise RuntimeError("cannot cache function: no locator available")
        self.kept.append(cache)
        stats = SimpleNamespace(cache_path=str(self.place))
        return lambda function: SimpleNamespace(py_func=function, stats=stats)


@pytest.mark.parametrize(("locators", "kept"), [("all", True), ("ours", True), ("none", False)])
def test_without_a_locator_the_cache_moves_or_goes(
    temporary: Path, monkeypatch: pytest.MonkeyPatch, locators: str, kept: bool
) -> None:
    fake = FakeNumba({"all": 9, "ours": 0, "none": 0}[locators], temporary)
    monkeypatch.setattr(jit.importlib, "import_module", lambda _: fake)
    if locators == "ours":
        real = fake.njit

        def njit(*, cache: bool, **rest: Any) -> Any:
            fake.folders = 1 if fake.config.CACHE_DIR else 0
            return real(cache=cache, **rest)

        fake.njit = njit  # type: ignore[method-assign]
    assert jit.compile_kernel(twice).py_func is twice
    assert fake.kept == [kept]
    assert bool(fake.config.CACHE_DIR) is (locators != "all")


KERNEL = """
from qrobot._jit import compile_kernel
def twice(x):
    return 2 * x
twice = compile_kernel(twice)
"""

ASK = """
from package import kernels
from pathlib import Path
from qrobot._jit import is_cached
known = is_cached(Path(kernels.__file__), "twice")
assert kernels.twice(21) == 42
stats = kernels.twice.stats
print(known, sum(stats.cache_hits.values()), stats.cache_path)
"""


def ask(root: Path, script: str = ASK, **environment: str) -> list[str]:
    """Call a kernel in a process of its own; is it cached, was it loaded, and from where."""
    # An account that may write where the mode forbids it loses that right.
    bound = ["setpriv", "--bounding-set=-dac_override"] if os.getuid() == 0 else []
    done = subprocess.run(
        [*bound, sys.executable, "-c", script],
        env={"PATH": os.environ["PATH"], "PYTHONPATH": f"{PROJECT}:{root}", "HOME": "/"}
        | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.slow
@pytest.mark.skipif(not jit.available(), reason="numba is not installed")
@pytest.mark.skipif(shutil.which("setpriv") is None, reason="setpriv is not installed")
def test_machine_code_that_came_along_is_used_by_those_who_cannot_write_there(
    tmp_path: Path,
) -> None:
    """A release or an image: compiled by its owner beside the package, run by another account."""
    source, cache = tmp_path / "package/kernels.py", tmp_path / "cache"
    beside = source.parent / "__pycache__"
    beside.mkdir(parents=True)
    source.write_text(KERNEL)
    processor = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    assert ask(tmp_path, **processor) == ["False", "0", str(beside)]
    assert ask(tmp_path, **processor) == ["True", "1", str(beside)]
    beside.chmod(0o555)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "TMPDIR"):
        place = cache / name
        place.mkdir(parents=True)
        closed = {"XDG_CACHE_HOME": "/proc/none"} if name == "TMPDIR" else {}
        # Another processor's machine code is neither promised nor run.
        other = processor | {"NUMBA_CPU_NAME": "core2", name: str(place)} | closed
        if name == "NUMBA_CACHE_DIR" and platform.machine() == "x86_64":
            assert ask(tmp_path, **other)[:2] == ["False", "0"]
        known, hits, path = ask(tmp_path, **processor | {name: str(place)} | closed)
        assert (known, hits) == ("True", "1")
        assert path.startswith(str(place))
    # A source that was changed since is compiled anew, whatever the dates say.
    times = source.stat().st_atime, source.stat().st_mtime
    source.write_text(KERNEL.replace("2 * x", "x + 21"))
    os.utime(source, times)
    place = cache / "NUMBA_CACHE_DIR"
    known, hits, _ = ask(tmp_path, **processor, NUMBA_CACHE_DIR=str(place))
    assert (known, hits) == ("False", "0")


@pytest.mark.slow
@pytest.mark.skipif(not jit.available(), reason="numba is not installed")
@pytest.mark.parametrize("changed", ["part", "constants"])
def test_machine_code_is_not_that_of_an_older_part(tmp_path: Path, changed: str) -> None:
    """The file of the kernel stays as it is; what it calls, or a constant of that, is another."""
    package = tmp_path / "package"
    package.mkdir()
    (package / "constants.py").write_text("FACTOR = 2\n")
    (package / "part.py").write_text(
        "from qrobot._jit import compile_kernel\n"
        "from package.constants import FACTOR\n"
        "def times(x):\n    return FACTOR * x\n"
        "times = compile_kernel(times, inner=True)\n"
    )
    (package / "kernels.py").write_text(
        "from qrobot._jit import compile_kernel\n"
        "from package.part import times\n"
        "def twice(x):\n    return times(x)\n"
        "twice = compile_kernel(twice)\n"
    )
    place = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert ask(tmp_path, **place)[:2] == ["False", "0"]
    assert ask(tmp_path, **place)[:2] == ["True", "1"]
    file = package / f"{changed}.py"
    text = file.read_text().replace("FACTOR = 2", "FACTOR = 3").replace("FACTOR * x", "3 * x")
    file.write_text(text)
    asked = ASK.replace("== 42", "== 63")
    assert ask(tmp_path, asked, **place)[:2] == ["False", "0"]
    assert ask(tmp_path, asked, **place)[:2] == ["True", "1"]


@pytest.mark.slow
@pytest.mark.skipif(not jit.available(), reason="numba is not installed")
def test_machine_code_of_another_installation_is_taken_where_the_kernel_is_the_same(
    tmp_path: Path,
) -> None:
    package = tmp_path / "new/package"
    package.mkdir(parents=True)
    shutil.copy(jit.__file__, package / "_jit.py")
    (package / "_extras.py").write_text("def is_installed(name):\n    return True\n")
    mine = (package / "_jit.py").read_text().replace("from qrobot.", "from package.")
    (package / "_jit.py").write_text(mine)
    (package / "kernels.py").write_text(KERNEL.replace("qrobot", "package"))
    shutil.copytree(tmp_path / "new", tmp_path / "old")
    asked = ASK.replace("qrobot", "package")
    assert ask(tmp_path / "old", asked)[:2] == ["False", "0"]
    taking = f"""
from pathlib import Path
from package import _jit
_jit.older = Path({str(tmp_path / "old/package")!r})
{asked}"""
    assert ask(tmp_path / "new", taking)[1] == "1"
    shutil.rmtree(package / "__pycache__")
    (package / "kernels.py").write_text(
        (package / "kernels.py").read_text().replace("2 * x", "x + x")
    )
    assert ask(tmp_path / "new", taking)[1] == "0"


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package and, in `cache`, its machine code."""
    root = tmp_path_factory.mktemp("compiled")
    (root / "package").mkdir()
    (root / "package/kernels.py").write_text(KERNEL)
    ask(root, NUMBA_CACHE_DIR=str(root / "cache"))
    return root


@pytest.mark.skipif(not jit.available(), reason="numba is not installed")
@pytest.mark.parametrize("kind", ["nbc", "nbi"])
@pytest.mark.parametrize(
    "damage",
    ["half", *(pytest.param(one, marks=pytest.mark.slow) for one in ("empty", "zeros", "other"))],
)
def test_damaged_machine_code_is_compiled_anew(
    compiled: Path, tmp_path: Path, kind: str, damage: str
) -> None:
    """As after a loss of power, or a copy that was cut off."""
    shutil.copytree(compiled / "cache", tmp_path / "cache")
    place = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (file,) = (tmp_path / "cache").rglob(f"*.{kind}")
    content = file.read_bytes()
    broken = {
        "empty": b"",
        "half": content[: len(content) // 2],
        "zeros": bytes(len(content)),
        "other": b"no machine code\n",
    }
    file.write_bytes(broken[damage])
    assert ask(compiled, **place)[1] == "0"
    assert ask(compiled, **place)[1] == "1"


@pytest.mark.skipif(not jit.available(), reason="numba is not installed")
def test_a_full_disk_switches_the_cache_off(monkeypatch: pytest.MonkeyPatch) -> None:
    from qrobot.backends.gate.state import compiled, kernels

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernels, "moments", full)
    monkeypatch.setattr(jit, "caching", True)
    compiled._kernels.cache_clear()
    try:
        compiled._kernels()
        assert jit.caching is False
    finally:
        jit.caching = True
        compiled._kernels.cache_clear()
        compiled._kernels()
