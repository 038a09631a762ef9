"""Releases bring the machine code of the searches along."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest
from release_house import load, lock, uv, wheel

release = load()

COMPILING = """
import pathlib, sys
if sys.argv[1:] == ["compile"]:
    pathlib.Path(__file__).with_name("__pycache__").joinpath("kernel.nbi").touch()
"""


def real(tmp_path: Path, requirements: str, name: str) -> tuple[Any, Any]:
    made = release.Releases(tmp_path / "root")
    return made, made.install(name, requirements, tmp_path / "wheels", uv(), sys.executable)


def test_the_searches_are_compiled_when_a_release_is_made_and_go_with_it(tmp_path: Path) -> None:
    ours = wheel(tmp_path / "wheels", "qrobot", "1.0", COMPILING)
    compiler = wheel(tmp_path / "wheels", "numba", "1.0")
    made, _ = real(tmp_path, lock(ours), "plain")
    assert not list(made.folder.rglob("*.nbi"))  # the profile base has no numba
    mask = os.umask(0o077)
    try:
        real(tmp_path, lock(ours, compiler), "a")
    finally:
        os.umask(mask)
    (kept,) = made.folder.rglob("*.nbi")
    assert kept.parent.name == "__pycache__"
    for path in [kept, *kept.parents[: len(kept.relative_to(made.root).parts)]]:
        assert path.stat().st_mode & 0o044 == 0o044, path
    before = kept.stat().st_mtime_ns
    assert real(tmp_path, lock(ours, compiler), "a")[1] == ("a", False)
    assert kept.stat().st_mtime_ns == before
    assert made.verify("a") == {"count": 0, "differences": []}
    made.discard("a")
    assert not kept.exists()

    # A release that cannot compile is made and says why: its proof refuses it.
    broken = wheel(tmp_path / "wheels", "qrobot", "1.1", "raise SystemExit('no such processor')\n")
    real(tmp_path, lock(broken, compiler), "b")
    assert made.uncompiled("b") == "no such processor"
    assert made.uncompiled("a") == ""
    full = wheel(
        tmp_path / "wheels", "qrobot", "1.2", "raise SystemExit('No space left on device')\n"
    )
    with pytest.raises(release.ReleaseError, match=r"No space left on device: make room"):
        real(tmp_path, lock(full, compiler), "c")
    assert not (made.folder / "c").exists()


def test_a_release_takes_over_the_machine_code_of_the_one_in_use(tmp_path: Path) -> None:
    compiler = wheel(tmp_path / "wheels", "numba", "1.0")
    told = """
import pathlib, sys
pathlib.Path(__file__).with_name("told").write_text(" ".join(sys.argv[1:]))
"""
    first = wheel(tmp_path / "wheels", "qrobot", "1.0", told)
    made, _ = real(tmp_path, lock(first, compiler), "a")
    (said,) = (made.folder / "a").rglob("told")
    assert said.read_text() == "compile"
    package = said.with_name("qrobot")
    package.mkdir()
    made.switch("a")
    second = wheel(tmp_path / "wheels", "qrobot", "1.1", told)
    real(tmp_path, lock(second, compiler), "b")
    (now,) = (made.folder / "b").rglob("told")
    assert now.read_text() == f"compile --from {package}"
