"""Run the tutorial as a notebook: ``python examples/run_tutorial.py build/tutorial.ipynb``."""

from __future__ import annotations

import sys
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient

EXAMPLES = Path(__file__).resolve().parent


def main(target: Path) -> None:
    """Execute the cells in the project's folder and write the notebook with its outputs."""
    notebook = jupytext.read(EXAMPLES / "tutorial.py")
    client = NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": str(EXAMPLES.parent)}}
    )
    try:
        client.execute()
    finally:
        target.parent.mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, target)
    print(f"The notebook: {target}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/tutorial.ipynb"))
