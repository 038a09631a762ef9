"""The tutorial runs, as a notebook, and its own assertions hold."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from gates_sdk.stacks import needs

ROOT = Path(__file__).parents[2]


@needs("qiskit")
def test_the_tutorial_runs_as_a_notebook(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="make setup installs the notebook tools")
    target = tmp_path / "tutorial.ipynb"
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "run_tutorial.py", target],
        capture_output=True, text=True, cwd=tmp_path, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    cells = nbformat.read(target, as_version=4).cells
    code = [cell for cell in cells if cell.cell_type == "code"]
    assert code
    assert all(cell.execution_count for cell in code)
    pictures = [o for cell in code for o in cell.outputs if "image/png" in o.get("data", {})]
    assert len(pictures) == 2
    text = "".join(o.get("text", "") for cell in code for o in cell.outputs)
    assert "proven optimal" in text
