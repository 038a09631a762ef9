"""What a Python that we start must know to be as we are.

It is started with ``-P``: a file ``numpy.py`` in the folder that somebody happens to be in, which
may be a mounted one, is not numpy.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

__all__ = ["child_environment", "import_path"]


def child_environment() -> dict[str, str]:
    """Return the variables for a Python that answers us over a pipe, whatever our own streams."""
    return os.environ | {"PYTHONPATH": import_path(), "PYTHONIOENCODING": "utf-8"}


def import_path() -> str:
    """Return a ``PYTHONPATH`` of all that we can import, and ourselves.

    The current folder is not in it, unless it was named.
    """
    ourselves = Path(__file__).resolve().parents[1]
    paths = [os.path.abspath(path) for path in sys.path if path]
    return os.pathsep.join([*paths, str(ourselves)])
