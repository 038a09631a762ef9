"""Where a check runs: a folder of its own, and what it sees of the environment.

A check must run in a container whose file system is read-only and whose user has no home, must
not be led astray by somebody's matplotlibrc or IPython start-up files, and leaves nothing
behind. Caches that outlive it (numba's machine code) are left where they are, if that place
takes files.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from qrobot._processes import child_environment

__all__ = ["ROOT", "environment", "own_folder"]

ROOT = Path(__file__).resolve().parents[2]
"""The folder that holds qRobot."""

CLOUDS = ("AWS_", "DWAVE_", "QISKIT_IBM")
"""Beginnings of variables that a check has no business to know: none of them asks a cloud."""

OWN = (
    "IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR",
)  # fmt: skip
"""Variables that name folders of settings and sockets."""

CACHES = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
"""Variables that name folders that are worth keeping."""


@contextmanager
def own_folder() -> Iterator[Path]:
    """Give a temporary folder, and delete it with all that is in it.

    Raises
    ------
    OSError
        When no folder can be made.
    """
    folder = Path(tempfile.mkdtemp(prefix="qrobot-health-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def environment(folder: Path, seen: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the variables for a check that runs in a folder.

    Parameters
    ----------
    folder
        Its own; what the user did not choose otherwise points into it.
    seen
        The variables to begin with.
    """
    found = child_environment({n: value for n, value in seen.items() if not _is_secret(n)})
    found["TMPDIR"] = str(folder)  # which is in the user's own
    found["PYTHONWARNINGS"] = "ignore"  # what an SDK thinks of its own parts
    for name in OWN if _takes_files(_caches(found)) else (*OWN, *CACHES):
        found.setdefault(name, str(folder / name.lower()))
    return found


def _is_secret(variable: str) -> bool:
    """Return whether a variable may hold a credential; a proxy's address may have a password."""
    from qrobot.jobs.redaction import SECRET_VARIABLE  # here: the other processes need it not

    name = variable.upper()
    return name.startswith(CLOUDS) or name.endswith("_PROXY") or bool(SECRET_VARIABLE.search(name))


def _caches(variables: Mapping[str, str]) -> Path:
    home = variables.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(home)


def _takes_files(folder: Path) -> bool:
    """Return whether files can be made in a folder, or the folder itself can be."""
    try:
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
