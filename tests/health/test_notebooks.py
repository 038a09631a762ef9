"""Every check has its notebook, which teaches, runs, and fails when its stack is wrong."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest
from health.executed import error_kept, executes, outputs, run_notebook

from qrobot.health import Check, all_checks

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "healthchecks"
CHECKS = all_checks()

NOISY = {"litert", "tensorflow"}
"""Their libraries write to the standard error stream when they start."""


def source(check: Check) -> Path:
    return SOURCES / f"check_{check.name.replace('-', '_')}.py"


# --- the sources ----------------------------------------------------------------------------------


def test_every_check_has_its_notebook_and_every_notebook_its_check() -> None:
    assert {path.name for path in SOURCES.glob("*.py")} == {
        source(check).name for check in CHECKS.values()
    }


@pytest.mark.parametrize("name", CHECKS)
def test_a_notebook_teaches_and_ends_with_the_checks_own_verdict(name: str) -> None:
    check = CHECKS[name]
    text = source(check).read_text()
    assert text.startswith("# %% [markdown]\n# # ")
    assert text.count("\n# ## Try it yourself\n") == 1
    tree = ast.parse(text)
    last = tree.body[-1]
    assert isinstance(last, ast.Expr)
    assert ast.unparse(last).startswith("verdict(CHECK")
    wanted = {"CHECK": check.module, "verdict": "qrobot.health.lesson"}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                assert wanted.get(alias.asname or alias.name, node.module) == node.module
        elif isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            assert node.id not in wanted
    imported = {a.name for n in tree.body if isinstance(n, ast.ImportFrom) for a in n.names}
    assert set(wanted) <= imported


def test_a_reader_finds_every_notebook_that_the_readme_names() -> None:
    words = (SOURCES / "README.md").read_text().replace("`", " ").replace(",", " ").split()
    named = {word for word in words if word.startswith("check_") and "." not in word}
    assert named
    assert named <= {path.stem for path in SOURCES.glob("*.py")}


# --- the notebooks --------------------------------------------------------------------------------


@pytest.mark.slow
@executes
@pytest.mark.parametrize("name", CHECKS)
def test_a_notebook_runs_and_passes(name: str, tmp_path: Path) -> None:
    check = CHECKS[name]
    absent = set(check.distributions) - set(check.versions())
    if absent:
        pytest.skip(f"{', '.join(sorted(absent))} not installed")
    found = run_notebook(check, tmp_path)
    assert found.status == "pass", found.message
    assert found.versions == check.versions()
    assert found.answer is not None
    assert len(found.answer) == len(found.expected or ()) > 0
    assert found.run_seconds is not None
    assert found.peak_mb is not None
    shown = outputs(tmp_path, name)
    assert not [o for o in shown if o.output_type == "error"]
    assert "PASS" in shown[-1].data["text/plain"]
    assert len(shown) > 1, "it shows nothing but the verdict"
    if name not in NOISY:
        assert not [o.text for o in shown if o.get("name") == "stderr"]


SPOIL = """
import importlib
from health.sabotage import SABOTAGE
where, spoil = SABOTAGE[{name!r}]
module, _, path = where.partition(":")
owner = importlib.import_module(module)
*way, last = path.split(".")
for part in way:
    owner = getattr(owner, part)
setattr(owner, last, spoil(getattr(owner, last)))
"""


@pytest.mark.slow
@executes
@pytest.mark.parametrize("name", ["numpy", "dimod", "autograd", "qrobot"])
def test_a_spoiled_stack_fails_its_notebook(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = CHECKS[name]
    if set(check.distributions) - set(check.versions()):
        pytest.skip(f"{name} is not installed")
    (tmp_path / "sitecustomize.py").write_text(SPOIL.format(name=name))  # Python runs it first
    monkeypatch.syspath_prepend(str(tmp_path))
    found = run_notebook(check, tmp_path)
    assert found.status == "fail", found.message
    assert "expected is" in found.message
    assert str(tmp_path / f"{name}.ipynb") in found.message
    assert found.answer != found.expected
    assert error_kept(tmp_path, name).startswith("AssertionError: number ")


def test_a_notebook_is_a_plain_script_too(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, SOURCES / "check_numpy.py"],
        capture_output=True, text=True, check=True, cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert "eigenvalue 1" in done.stdout
    assert done.stdout.splitlines()[-1].startswith("PASS")
