"""The checks: one file a stack, found by being here; each holds a `CHECK`.

Importing them imports no SDK.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence

from qrobot.errors import InputError
from qrobot.health.check import PROFILES, Check

__all__ = ["all_checks", "choose"]

GROUPS = ("base", "annealing", "gate model", "modelling", "solver", "science", "lab")
"""In the sequence that they are shown in."""


def all_checks() -> dict[str, Check]:
    """Return every check by its name, group after group."""
    found: list[Check] = [
        importlib.import_module(f"{__name__}.{entry.name}").CHECK
        for entry in pkgutil.iter_modules(__path__)
    ]
    found.sort(key=lambda check: (GROUPS.index(check.group), check.name))
    return {check.name: check for check in found}


def choose(
    names: Sequence[str] = (), *, quick: bool = False, profile: str | None = None
) -> list[Check]:
    """Return the checks of these names, each once, or all when none is named.

    Parameters
    ----------
    names
        Of checks; then neither of the others may be given.
    quick
        Only those that are cheap.
    profile
        Only those of stacks that an installation of this profile must have: base, solver, edge
        or full, each holding the one before. None for all stacks, installed or not.

    Raises
    ------
    InputError
        When there is no check or profile of a name, or the choice is made twice.
    """
    for given, option in ((quick, "--quick"), (profile is not None, "--profile")):
        if names and given:
            raise InputError(
                f"{option} chooses the checks itself", field="NAMES", advice="leave one of both out"
            )
    if profile is not None and profile not in PROFILES:
        raise InputError(
            f"{profile!r} is not a profile",
            field="profile",
            advice=f"use one of: {', '.join(PROFILES)}",
        )
    known = all_checks()
    for name in names:
        if name not in known:
            raise InputError(
                f"{name!r} is not a check", field="NAMES", advice=f"use some of: {', '.join(known)}"
            )
    chosen = [known[name] for name in dict.fromkeys(names)] or list(known.values())
    return [
        check
        for check in chosen
        if (check.quick or not quick) and (profile is None or check.belongs(profile))
    ]
