"""What a check is: which imports, which computation, which answer."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass

from qrobot._extras import distribution_version, extras
from qrobot._version import __version__

__all__ = ["PROFILES", "Check", "difference", "first_profile"]

PROFILES = ("base", "solver", "edge", "full")
"""What can be installed; each holds all of the one before."""


@dataclass(frozen=True)
class Check:
    """One stack and something that it must compute right.

    It stands at the end of a file with two functions. ``answer`` lets the stack compute numbers,
    and imports its SDK inside; ``expected`` returns the same numbers from a source that shares no
    code with the stack.

    Parameters
    ----------
    module
        The file's own ``__name__``: the process of the check imports it again.
    title, group
        For people.
    imports
        Modules of the stack; importing them is timed by itself.
    source
        Where the expected answer comes from, as a clause.
    distributions
        What must be installed, by the names that pip knows; by default those of `imports`. One
        that is not there makes the check absent; one that is there and cannot be imported makes it
        an error.
    tolerance
        Largest allowed absolute difference.
    extra
        The extra of qRobot that installs the stack, None when it is in the base.
    quick
        Part of ``--quick``: cheap enough to be run every minute on a Pi.
    """

    module: str
    title: str
    group: str
    imports: tuple[str, ...]
    source: str
    distributions: tuple[str, ...] = ()
    tolerance: float = 1e-9
    extra: str | None = None
    quick: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "distributions", self.distributions or self.imports)

    @property
    def name(self) -> str:
        """The name of the file, with dashes."""
        return self.module.rpartition(".")[2].replace("_", "-")

    @property
    def profile(self) -> str:
        """The first profile that has the stack."""
        return first_profile(self.extra)

    def belongs(self, profile: str) -> bool:
        """Return whether an installation of a profile has the stack."""
        return PROFILES.index(self.profile) <= PROFILES.index(profile)

    def answer(self) -> list[float]:
        """Return what the stack computes."""
        return [float(number) for number in importlib.import_module(self.module).answer()]

    def expected(self) -> list[float]:
        """Return what it should compute."""
        return [float(number) for number in importlib.import_module(self.module).expected()]

    def versions(self) -> dict[str, str]:
        """Return the versions of the distributions that are installed; nothing is imported."""
        found = {name: distribution_version(name) for name in self.distributions}
        if "qrobot" in found:  # run from its sources: we are here, so it is
            found["qrobot"] = found["qrobot"] or __version__
        return {name: version for name, version in found.items() if version}


def first_profile(extra: str | None) -> str:
    """Return the first profile that has an extra, by what both install; None is the base."""
    if extra is None:
        return "base"
    needed = extras().get(extra)
    return next((p for p in PROFILES if needed and needed <= extras().get(p, set())), "full")


def difference(answer: Sequence[float], expected: Sequence[float], tolerance: float) -> str:
    """Say how an answer differs from the expected one, or ``""`` when it does not."""
    if len(answer) != len(expected):
        return f"the answer has {len(answer)} numbers, expected are {len(expected)}"
    for place, (got, wanted) in enumerate(zip(answer, expected, strict=True)):
        if not abs(got - wanted) <= tolerance:  # so that nan is wrong too
            return f"number {place + 1} is {got:.9g}, expected is {wanted:.9g} ± {tolerance:g}"
    return ""
