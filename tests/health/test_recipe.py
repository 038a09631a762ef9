"""The recipe of a health check: who adds what the page names has a check that every test takes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages.blocks import ROOT, blocks_of

HOUSE = ("qrobot", "healthchecks", "locks", "tests", "pyproject.toml")
TESTS = ("test_answers.py", "test_notebooks.py", "test_profiles.py")


def copy_house(folder: Path) -> None:
    for name in HOUSE:
        if (ROOT / name).is_dir():
            shutil.copytree(
                ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__")
            )
        else:
            shutil.copy(ROOT / name, folder)


def follow_recipe(folder: Path) -> None:
    blocks = [block.text for block in blocks_of(ROOT / "docs/extending.md")]
    (check,) = (text for text in blocks if "CHECK = Check(" in text)
    (notebook,) = (text for text in blocks if text.startswith("# %%"))
    (line,) = (text for text in blocks if text.startswith('    "networkx": '))
    (folder / "qrobot/health/checks/networkx.py").write_text(check)
    (folder / "healthchecks/check_networkx.py").write_text(notebook)
    sabotage = folder / "tests/health/sabotage.py"
    text, places = re.subn(r"(?m)^SABOTAGE: .* = \{\n", rf"\g<0>{line}", sabotage.read_text())
    assert places == 1
    sabotage.write_text(text)


@pytest.mark.slow
def test_a_check_is_what_the_recipe_names_and_nothing_more(tmp_path: Path) -> None:
    pytest.importorskip("networkx", reason="networkx is not installed")
    copy_house(tmp_path)
    follow_recipe(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-rA", "-p", "no:cacheprovider",
         *(f"tests/health/{name}" for name in TESTS),
         "-k", "networkx or every_check or nested or those_of_the_project"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    passed = set(re.findall(r"^PASSED .*::(test_\w+)\[networkx", done.stdout, re.MULTILINE))
    assert "test_a_spoiled_stack_is_noticed" in passed
    assert "test_a_notebook_teaches_and_ends_with_the_checks_own_verdict" in passed
    health = [sys.executable, "-m", "qrobot", "health", "networkx", "--no-system"]
    ran = subprocess.run(health, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)},
                         capture_output=True, text=True, check=False)  # fmt: skip
    assert ran.returncode == 0, ran.stdout + ran.stderr
