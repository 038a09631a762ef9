"""What a check is: which imports, which computation, which answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from qrobot._version import __version__

__all__ = ["PROFILES", "Check", "difference"]

PROFILES = ("base", "solver", "edge", "full")
"""What can be installed; each holds all of the one before."""

FIRST_HELD = {
    None: "base",
    "planners": "solver",
    "plot": "solver",
    "qiskit": "edge",
    "ibm": "edge",
    "pennylane": "edge",
    "braket": "edge",
    "dwave": "edge",
    "docplex": "edge",
    "edge": "edge",
    "science": "full",
    "lab": "full",
}
"""The first profile that has an extra; a test holds it against ``pyproject.toml``."""


@dataclass(frozen=True)
class Check:
    """One stack and something that it must compute right.

    Parameters
    ----------
    module
        The file's own ``__name__``: the process of the check imports it again.
    title, group
        For people.
    imports
        Modules of the stack; importing them is timed by itself.
    distributions
        What must be installed, by the names that pip knows. One that is not there makes the
        check absent; one that is there and cannot be imported makes it an error.
    answer
        Lets the stack compute; its SDK is imported inside.
    expected
        The same numbers from a source that shares no code with the stack.
    source
        Where `expected` comes from, as a clause.
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
    distributions: tuple[str, ...]
    answer: Callable[[], Sequence[float]]
    expected: Callable[[], Sequence[float]]
    source: str
    tolerance: float = 1e-9
    extra: str | None = None
    quick: bool = False

    @property
    def name(self) -> str:
        """The name of the file, with dashes."""
        return self.module.rpartition(".")[2].replace("_", "-")

    @property
    def profile(self) -> str:
        """The first profile that has the stack."""
        return FIRST_HELD[self.extra]

    def belongs(self, profile: str) -> bool:
        """Return whether an installation of a profile has the stack."""
        return PROFILES.index(self.profile) <= PROFILES.index(profile)

    def versions(self) -> dict[str, str]:
        """Return the versions of the distributions that are installed; nothing is imported."""
        import importlib.metadata  # here: the processes of the checks need it not

        found: dict[str, str] = {}
        for name in self.distributions:
            try:
                found[name] = importlib.metadata.version(name)
            except importlib.metadata.PackageNotFoundError:
                if name == "qrobot":  # run from its sources: we are here, so it is
                    found[name] = __version__
        return found


def difference(answer: Sequence[float], expected: Sequence[float], tolerance: float) -> str:
    """Say how an answer differs from the expected one, or ``""`` when it does not."""
    if len(answer) != len(expected):
        return f"the answer has {len(answer)} numbers, expected are {len(expected)}"
    for place, (got, wanted) in enumerate(zip(answer, expected, strict=True)):
        if not abs(got - wanted) <= tolerance:  # so that nan is wrong too
            return f"number {place + 1} is {got:.9g}, expected is {wanted:.9g} ± {tolerance:g}"
    return ""
