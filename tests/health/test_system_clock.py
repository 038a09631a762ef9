"""Whether the clock is kept right, as the kernel says it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from health.made_up import machine

from qrobot.health.system.software import clock, synchronised


@pytest.mark.parametrize(
    ("state", "status"), [(True, "good"), (False, "warning"), (None, "unknown")]
)
def test_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, state: bool | None, status: str
) -> None:
    monkeypatch.setattr(sys.modules[clock.__module__], "synchronised", lambda: state)
    (finding,) = clock(machine(tmp_path))
    assert (finding.status, finding.value) == (status, state)


def test_the_kernels_own_word_on_the_clock_agrees(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", os.defpath)
    tool = shutil.which("adjtimex") or shutil.which("ntptime")
    if tool is None:
        pytest.skip("no other program to ask the kernel")
    said = subprocess.run([tool, *(["-p"] if "adjtimex" in tool else [])],
                          capture_output=True, text=True, check=False).stdout  # fmt: skip
    assert synchronised() is not ("UNSYNC" in said or "status: 64" in said)
