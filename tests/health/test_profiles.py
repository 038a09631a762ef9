"""Which checks there are, and which installation must have which."""

from __future__ import annotations

import base64
import importlib.metadata
import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import locks
from qrobot.errors import InputError
from qrobot.health import PROFILES, all_checks, choose
from qrobot.health.check import first_profile

PROJECT = tomllib.loads((Path(__file__).resolve().parents[2] / "pyproject.toml").read_text())
EXTRAS: dict[str, list[str]] = PROJECT["project"]["optional-dependencies"]

STACKS = {
    "aer", "autograd", "braket", "braket-ahs", "dimod", "docplex", "dwave-networkx",
    "dwave-system", "h5py", "ibm-runtime", "jupyter", "lightning", "litert", "minorminer", "neal",
    "numpy", "pennylane", "pennylane-braket", "pyscf", "qiskit", "qiskit-algorithms",
    "qiskit-finance", "qiskit-machine-learning", "qiskit-nature", "qiskit-optimization", "qrobot",
    "rustworkx", "scipy", "tabu", "tensorflow",
}  # fmt: skip
"""What the paper's appendix installs, and the solver."""


def extras_of(name: str) -> set[str]:
    """Return an extra and those that it takes in."""
    found = {name}
    for line in EXTRAS[name]:
        requirement = Requirement(line)
        if requirement.name == "qrobot":
            for extra in requirement.extras:
                found |= extras_of(extra)
    return found


def brought_by(lines: list[str]) -> set[str]:
    """Return the distributions that these requirements install, as far as they are here."""
    found: set[str] = set()
    waiting = [(Requirement(line), "") for line in lines]
    while waiting:
        requirement, extra = waiting.pop()
        name = re.sub("[-_.]+", "-", requirement.name).lower()
        wanted = requirement.marker is None or requirement.marker.evaluate({"extra": extra})
        if not wanted or name in found or name == "qrobot":
            continue
        found.add(name)
        try:
            needs = importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:
            continue
        for chosen in ("", *requirement.extras):
            waiting += [(Requirement(line), chosen) for line in needs]
    return found


def brought_directly(lines: list[str]) -> set[str]:
    """Return the distributions that these requirements name, for this Python."""
    requirements = [Requirement(line) for line in lines]
    return {r.name for r in requirements if r.marker is None or r.marker.evaluate()} - {"qrobot"}


def installed(name: str) -> bool:
    try:
        return bool(importlib.metadata.version(name))
    except importlib.metadata.PackageNotFoundError:
        return False


def test_every_stack_of_the_paper_has_its_check() -> None:
    assert set(all_checks()) >= STACKS


def test_extras_and_profiles_are_those_of_the_project() -> None:
    for check in all_checks().values():
        assert check.extra is None or check.extra in EXTRAS, check.name
    for extra in EXTRAS:
        holders = [p for p in PROFILES if p != "base" and extra in extras_of(p)]
        if extra in PROFILES or not holders:
            continue  # the profiles themselves, and what only a developer installs
        assert first_profile(extra) == holders[0], extra


@pytest.mark.parametrize("name", all_checks())
def test_an_installation_brings_what_its_checks_need(name: str) -> None:
    check = all_checks()[name]
    missing = [known for known in check.distributions if known not in check.versions()]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed")
    lines = list(PROJECT["project"]["dependencies"])
    if check.extra is not None:
        for extra in extras_of(check.extra):
            lines += EXTRAS[extra]
    brought = brought_by(lines)
    if check.extra is not None and not all(map(installed, brought_directly(lines))):
        pytest.skip(f"the extra {check.extra} is not installed as a whole")
    assert set(check.distributions) - {"qrobot"} <= brought


def test_profiles_are_those_of_the_locks() -> None:
    assert [profile for profile in locks.PROFILES if profile != "dev"] == list(PROFILES)


def test_profiles_are_nested() -> None:
    before: set[str] = set()
    for profile in PROFILES:
        names = {check.name for check in choose(profile=profile)}
        assert names > before
        before = names
    assert before == set(all_checks())
    edge = {check.name for check in choose(profile="edge")}
    assert {"numpy", "pyvrp", "braket-ahs", "dwave-cloud"} <= edge
    assert not edge & {"tensorflow", "pyscf", "litert", "jupyter", "qiskit-nature"}


def test_quick_and_a_profile_go_together() -> None:
    quick = {check.name for check in choose(quick=True)}
    assert {check.name for check in choose(quick=True, profile="edge")} == quick
    assert quick <= {check.name for check in choose(profile="base")}


@pytest.mark.parametrize(
    ("names", "profile", "told"),
    [((), "robot", "'robot' is not a profile"), (("numpy",), "edge", "--profile chooses")],
)
def test_a_bad_choice_is_refused(names: tuple[str, ...], profile: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        choose(names, profile=profile)


def test_the_network_of_litert_is_what_its_recipe_makes() -> None:
    pytest.importorskip("ai_edge_litert", reason="ai-edge-litert is not installed")
    from health.small_network import build

    from qrobot.health.checks.litert import NETWORK

    assert base64.b64decode(NETWORK) == build()
