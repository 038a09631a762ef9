"""What the tests of notebooks share: where they can run, and what an executed copy holds."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from qrobot.health import Check, CheckResult, Limits
from qrobot.health.notebooks import TOOLS, run_notebooks

executes = pytest.mark.skipif(
    not all(importlib.util.find_spec(tool) for tool in TOOLS),
    reason="the notebook tools are not installed: pip install 'qrobot[lab]'",
)


def run_notebook(check: Check, folder: Path, limits: Limits | None = None) -> CheckResult:
    """Return the result of one notebook, whose copy must have been written."""
    (result,), troubles = run_notebooks([check], folder, limits)
    for trouble in troubles:
        raise trouble
    return result


def outputs(folder: Path, name: str) -> list[Any]:
    """Return what the cells of an executed copy showed, which must be a valid notebook."""
    import nbformat

    notebook = nbformat.read(folder / f"{name}.ipynb", as_version=4)
    nbformat.validate(notebook)
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]


def error_kept(folder: Path, name: str) -> str:
    """Return the one error that the executed copy holds."""
    (error,) = (o for o in outputs(folder, name) if o.output_type == "error")
    return f"{error.ename}: {error.evalue}"
