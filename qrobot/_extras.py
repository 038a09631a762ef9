"""Optional packages: which are there, and which extra of qRobot brings one that is not.

The extras are those of the distribution's own metadata (``pyproject.toml``); nobody else lists
what they hold.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import re
from functools import cache
from typing import Any

from qrobot.errors import INSTALL, MissingExtraError

__all__ = [
    "DISTRIBUTIONS",
    "distribution_version",
    "extra_of",
    "extras",
    "install_command",
    "is_installed",
    "load",
    "missing",
]

DISTRIBUTIONS = {
    "PIL": "pillow",
    "braket": "amazon-braket-sdk",
    "dwave": "dwave-system",
    "yaml": "pyyaml",
}
"""Of modules that are not called like what installs them."""


@cache
def extras() -> dict[str, frozenset[str]]:
    """Return what each extra installs, by the names of distributions; the base is ``""``.

    Nothing is known where qRobot runs from its sources without having been installed.
    """
    found: dict[str, set[str]] = {}
    try:
        lines = importlib.metadata.requires("qrobot") or []
    except importlib.metadata.PackageNotFoundError:
        lines = []
    for line in lines:
        name = re.match(r"[\w.-]+", line)
        extra = re.search(r"extra == ['\"]([\w-]+)['\"]", line)
        if name:
            found.setdefault(extra[1] if extra else "", set()).add(name[0].lower())
    return {extra: frozenset(names) for extra, names in found.items()}


def extra_of(module: str) -> str | None:
    """Return the smallest extra that installs a module; None: the base does, or no extra."""
    parts = module.replace("_", "-").split(".")
    names = ["-".join(parts[:length]) for length in range(len(parts), 0, -1)]
    names.append(DISTRIBUTIONS.get(parts[0], ""))
    for name in names:
        if holding := [extra for extra, held in extras().items() if name in held]:
            return (
                min(holding, key=lambda extra: (len(extras()[extra]) if extra else 0, extra))
                or None
            )
    return None


def install_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return INSTALL.format(extra)


def distribution_version(name: str) -> str | None:
    """Return the version of an installed distribution; nothing is imported."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def is_installed(module: str) -> bool:
    """Return whether a module could be imported; only the packages above it are."""
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def load(module: str, what: str) -> Any:
    """Return a module of an optional package that something needs, such as ``"backend pyvrp"``.

    Raises
    ------
    MissingExtraError
        With the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise missing(what, module) from None


def missing(what: str, module: str) -> MissingExtraError:
    """Return the error that says how to install a module: all of qRobot, where no extra has it."""
    return MissingExtraError(what, extra_of(module) or "full")
