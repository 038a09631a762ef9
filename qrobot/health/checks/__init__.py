"""The checks: one file a stack, found by being here; each holds a `CHECK`.

Importing them imports no SDK.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence

from qrobot.errors import InputError
from qrobot.health.check import Check

__all__ = ["all_checks", "choose"]

GROUPS = ("base", "annealing", "gate model", "modelling", "solver")
"""In the sequence that they are shown in."""


def all_checks() -> dict[str, Check]:
    """Return every check by its name, group after group."""
    found: list[Check] = [
        importlib.import_module(f"{__name__}.{entry.name}").CHECK
        for entry in pkgutil.iter_modules(__path__)
    ]
    found.sort(key=lambda check: (GROUPS.index(check.group), check.name))
    return {check.name: check for check in found}


def choose(names: Sequence[str] = (), *, quick: bool = False) -> list[Check]:
    """Return the checks of these names, each once, or all (quick) ones when none is named.

    Raises
    ------
    InputError
        When there is no check of a name, or the choice is made twice.
    """
    if names and quick:
        raise InputError(
            "--quick chooses the checks itself", field="NAMES", mend="leave one of both out"
        )
    known = all_checks()
    for name in names:
        if name not in known:
            raise InputError(
                f"{name!r} is no check", field="NAMES", mend=f"use some of: {', '.join(known)}"
            )
    chosen = [known[name] for name in dict.fromkeys(names)] or list(known.values())
    return [check for check in chosen if check.quick or not quick]
