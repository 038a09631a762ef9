"""The scripts that build and compare, as far as they need no image."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from images.engine import ROOT

LOCKS = ROOT / "locks"


def names(text: str, machine: str) -> set[str]:
    """What a requirements file asks for on a machine, read by packaging line by line."""
    from packaging.requirements import Requirement

    found = set()
    for line in text.splitlines():
        if line[:1].isalnum():
            pin = Requirement(line.rstrip(" \\"))
            here = {"platform_machine": machine, "sys_platform": "linux"}
            if pin.marker is None or pin.marker.evaluate(here):
                found.add(pin.name)
    return found


def above(lock: str, below: str, arch: str) -> str:
    script = [sys.executable, "-m", "locks.above", LOCKS / lock, LOCKS / below, arch]
    return subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(("arch", "machine"), [("arm64", "aarch64"), ("amd64", "x86_64")])
def test_layers_on_top_of_each_other_hold_the_whole_lock(arch: str, machine: str) -> None:
    """Nothing twice, nothing missing: a pin below that is for Windows brings nothing."""
    solver = names((LOCKS / "solver.txt").read_text(), machine)
    edge = names(above("edge.txt", "solver.txt", arch), machine)
    full = names(above("full.txt", "edge.txt", arch), machine)
    assert not solver & edge
    assert not (solver | edge) & full
    assert solver | edge | full == names((LOCKS / "full.txt").read_text(), machine)
    assert "tzdata" in full


def test_what_is_taken_over_keeps_its_hashes() -> None:
    text = above("edge.txt", "solver.txt", "arm64")
    pins = [line for line in text.splitlines() if line[:1].isalnum()]
    assert len(pins) > 50
    for block in text.split("\n\n")[0].split("==")[1:]:
        assert "--hash=sha256:" in block


def compare(
    first: Any, second: Any, folder: Path, searches: tuple[str, str] = ("plain", "plain")
) -> tuple[int, str]:
    for name, answers, search in zip("ab", (first, second), searches, strict=True):
        document = {"machine": name, "python": "3", "search": search, "backends": answers}
        (folder / name).write_text(json.dumps(document))
    done = subprocess.run(
        [sys.executable, ROOT / "docker/plans.py", "compare", folder / "a", folder / "b"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout


def verdict(text: str, name: str) -> str:
    return next(line for line in text.splitlines() if line.startswith(f"{name} "))


@pytest.mark.slow
def test_a_comparison_notices_what_differs(tmp_path: Path) -> None:
    from qrobot.models import build_model
    from qrobot.problem.formats import read

    model = build_model(read("example:three-items"), encoding="compact")
    reads = {"kind": "sampler", "bits": ["0" * 9], "counts": [1], "cost": None}
    right = reads | {"energies": [float(model.bqm.offset)]}
    plan = {"kind": "planner", "cost": 1.0, "plan": {"trips": []}}
    same = {"neal": right, "exact": plan}

    code, told = compare(same, same, tmp_path)
    assert code == 1  # the backends that nobody ran are missing
    assert "missing on both" in verdict(told, "tabu")
    assert "identical plans" in verdict(told, "exact")
    assert "the same reads" in verdict(told, "neal")
    assert "WRONG" not in told

    for energy in (float("nan"), float(model.bqm.offset) + 1e-6):
        other = same | {"neal": reads | {"energies": [energy]}}
        _, told = compare(same, other, tmp_path)
        assert "WRONG" in verdict(told, "neal"), told
    _, told = compare(same, {"neal": right}, tmp_path)
    assert "missing on one" in verdict(told, "exact")
    _, told = compare(same, same | {"exact": plan | {"plan": {"trips": [1]}}}, tmp_path)
    assert "the plans differ" in verdict(told, "exact")
    assert "the same search" in verdict(told, "(whole")
    _, told = compare(same, same, tmp_path, ("plain", "compiled"))
    assert "DIFFERENT" in verdict(told, "(whole")
