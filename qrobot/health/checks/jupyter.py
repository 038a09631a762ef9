"""Jupyter: a notebook runs in a fresh kernel; JupyterLab and its server can be imported.

No server is started and no port is opened: the kernel is spoken to through files.
"""

import os
import tempfile

from qrobot.health.check import Check

CELLS = (
    "from fractions import Fraction\ntotal = sum(Fraction(1, k) for k in range(1, 11))",
    "print(total.numerator)",
    "total.denominator",
)


def answer() -> list[float]:
    """Return the tenth harmonic number: what one cell printed, and another one's value."""
    import nbclient
    from nbformat import v4 as formats
    from traitlets.config import Config

    notebook = formats.new_notebook(cells=[formats.new_code_cell(text) for text in CELLS])
    with tempfile.TemporaryDirectory(prefix="kernel-") as folder:
        # Linux allows 107 bytes of a socket's path; the way there from here may be the shorter one.
        near = min(folder, os.path.relpath(folder), key=len)
        manager = {"transport": "ipc", "ip": f"{near}/socket"}
        nbclient.NotebookClient(
            notebook, kernel_name="python3", config=Config({"KernelManager": manager})
        ).execute()
    printed, value = (cell.outputs[0] for cell in notebook.cells[1:])
    return [float(printed["text"]), float(value["data"]["text/plain"])]


def expected() -> list[float]:
    """Return 7381 / 2520 as published."""
    return [7381.0, 2520.0]


CHECK = Check(
    __name__,
    title="a notebook in a fresh kernel",
    group="lab",
    imports=("nbclient", "nbformat", "jupyter_server.serverapp", "jupyterlab.labapp"),
    distributions=("jupyterlab", "jupyter-server", "nbclient", "ipykernel"),
    source="the tenth harmonic number, 7381/2520 (OEIS A001008, A002805)",
    extra="lab",
)
