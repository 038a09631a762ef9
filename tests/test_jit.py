"""Where compiled code is kept, and what happens when it cannot be kept."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from qrobot import _jit as jit


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


class FakeNumba:
    """numba, with a cache that works only from a given number of folders on."""

    def __init__(self, folders: int) -> None:
        self.config = SimpleNamespace(CACHE_DIR="")
        self.folders = folders
        self.kept: list[bool] = []

    def njit(self, *, cache: bool, **_: Any) -> Any:
        if cache:
            self.folders -= 1
            if self.folders < 0:
                raise RuntimeError("cannot cache function: no locator available")
        self.kept.append(cache)
        return lambda function: function


@pytest.mark.parametrize(("locators", "kept"), [("all", True), ("ours", True), ("none", False)])
def test_without_a_locator_the_cache_moves_or_goes(
    temporary: Path, monkeypatch: pytest.MonkeyPatch, locators: str, kept: bool
) -> None:
    fake = FakeNumba({"all": 9, "ours": 0, "none": 0}[locators])
    monkeypatch.setattr(jit.importlib, "import_module", lambda _: fake)
    if locators == "ours":
        real = fake.njit

        def njit(*, cache: bool, **rest: Any) -> Any:
            fake.folders = 1 if fake.config.CACHE_DIR else 0
            return real(cache=cache, **rest)

        fake.njit = njit  # type: ignore[method-assign]
    assert jit.compile_kernel(abs) is abs
    assert fake.kept == [kept]
    assert bool(fake.config.CACHE_DIR) is (locators != "all")


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
