"""Whatever is broken or missing on a machine, what is left is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from health.made_up import PI4, machine, told
from hypothesis import given
from hypothesis import strategies as st

from qrobot.health.system import Machine

pytestmark = pytest.mark.usefixtures("no_tool")


def test_an_empty_root_tells_nothing_and_raises_nothing(tmp_path: Path) -> None:
    found = told(machine(tmp_path, {}, hwcap=0, libc="", architecture=""))
    for name in ("board", "temperature", "throttled", "cpu", "os", "memory", "swap-used"):
        assert found[name].status == "unknown"
        assert found[name].value is None


CGROUP = [f"sys/fs/cgroup/memory.{name}" for name in ("max", "current", "stat")]


@given(noise=st.binary(max_size=300))
def test_noise_in_every_file_raises_nothing(
    noise: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    root = tmp_path_factory.mktemp("noise")
    found = told(machine(root, dict.fromkeys([*PI4, *CGROUP], noise)))
    assert len(found) == 19
    assert not [name for name, finding in found.items() if "could not be told" in finding.message]


def test_folders_where_files_should_be_raise_nothing(tmp_path: Path) -> None:
    for name in PI4:
        (tmp_path / "root" / name).mkdir(parents=True)
    assert len(told(machine(tmp_path, {}))) == 19


def test_a_probe_that_raises_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: Machine, path: str) -> str:
        raise RuntimeError("secret words")

    monkeypatch.setattr(Machine, "text", broken)
    found = told(machine(tmp_path))
    assert found["board"].message == "could not be told: RuntimeError"
    assert "clock-synchronised" in found
