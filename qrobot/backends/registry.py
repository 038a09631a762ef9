"""Which backends exist, and how to get one by name.

A backend of ours is one file and one line in `BUILTIN`. Third parties add theirs by an
entry point in the group ``qrobot.backends`` whose value is a class or factory without
parameters.
"""

from __future__ import annotations

import importlib
import importlib.metadata
from typing import TYPE_CHECKING, cast

from qrobot._extras import extra_of, is_installed, missing
from qrobot._parameters import near
from qrobot.backends.base import Capabilities, Planner
from qrobot.errors import InputError

if TYPE_CHECKING:
    from qrobot.backends.sampler import PickingSampler

__all__ = [
    "BUILTIN",
    "GROUP",
    "available",
    "capabilities",
    "get",
    "get_planner",
    "names",
    "require",
]

GROUP = "qrobot.backends"

BUILTIN: dict[str, tuple[str, str, str]] = {
    # name: (module, class, module that must be importable)
    "auto": ("qrobot.planning.auto", "AutoPlanner", "numpy"),
    "exact": ("qrobot.backends.classical.exact", "ExactPlanner", "numpy"),
    "pyvrp": ("qrobot.backends.classical.pyvrp", "PyVRPPlanner", "pyvrp"),
    "pyvrp-plain": ("qrobot.backends.classical.pyvrp", "PlainPyVRPPlanner", "pyvrp"),
    "batching": ("qrobot.backends.classical.batching", "BatchingPlanner", "numpy"),
    "savings": ("qrobot.backends.classical.batching.rules", "SavingsPlanner", "numpy"),
    "seed": ("qrobot.backends.classical.batching.rules", "SeedPlanner", "numpy"),
    "fcfs": ("qrobot.backends.classical.batching.rules", "FirstComePlanner", "numpy"),
    "neal": ("qrobot.backends.annealing.samplers", "NealSampler", "dwave.samplers"),
    "tabu": ("qrobot.backends.annealing.samplers", "TabuSampler", "dwave.samplers"),
    "descent": ("qrobot.backends.annealing.samplers", "DescentSampler", "dwave.samplers"),
    "statevector": ("qrobot.backends.gate.statevector", "StatevectorSampler", "numpy"),
    "qaoa-swap": ("qrobot.backends.gate.constrained", "SwapPlanner", "numpy"),
    "qaoa-grover": ("qrobot.backends.gate.constrained", "GroverPlanner", "numpy"),
    "qiskit-qaoa": ("qrobot.backends.qiskit.sampler", "QiskitQAOA", "qiskit"),
    "qiskit-vqe": ("qrobot.backends.qiskit.sampler", "QiskitVQE", "qiskit"),
    "pennylane-qaoa": ("qrobot.backends.pennylane.sampler", "PennyLaneQAOA", "pennylane"),
    "pennylane-vqe": ("qrobot.backends.pennylane.sampler", "PennyLaneVQE", "pennylane"),
    "braket-qaoa": ("qrobot.backends.braket.sampler", "BraketQAOA", "braket.circuits"),
    "braket-vqe": ("qrobot.backends.braket.sampler", "BraketVQE", "braket.circuits"),
    "dwave-qpu": ("qrobot.backends.dwave.qpu", "DWaveQPUSampler", "dwave.system"),
    "leap-bqm": ("qrobot.backends.dwave.leap", "LeapBQMSampler", "dwave.system"),
    "leap-cqm": ("qrobot.backends.dwave.leap", "LeapCQMSampler", "dwave.system"),
    "leap-nl": ("qrobot.backends.dwave.leap", "LeapNLSampler", "dwave.system"),
}
"""In order of preference."""


def _plugins() -> dict[str, importlib.metadata.EntryPoint]:
    return {e.name: e for e in importlib.metadata.entry_points(group=GROUP)}


def names() -> list[str]:
    """Return the names that ``auto`` stands for: all others, installed or not, preferred first."""
    return [name for name in dict.fromkeys([*BUILTIN, *sorted(_plugins())]) if name != "auto"]


def available(name: str) -> bool:
    """Return whether a backend's software is installed, without importing it."""
    if name not in BUILTIN:
        return name in _plugins()
    return is_installed(BUILTIN[name][2])


def require(name: str) -> None:
    """Refuse a backend of ours whose software is absent, without importing anything.

    Raises
    ------
    MissingExtraError
        With the command that installs it.
    """
    if name in BUILTIN and not available(name):
        raise missing(f"backend {name}", BUILTIN[name][2])


def get(name: str) -> Planner | PickingSampler:
    """Return a backend by name.

    Raises
    ------
    InputError
        When no backend has that name.
    MissingExtraError
        When its software is not installed.
    """
    if name in BUILTIN:
        require(name)
        module, cls, _ = BUILTIN[name]
        return cast("Planner | PickingSampler", getattr(importlib.import_module(module), cls)())
    plugins = _plugins()
    if name in plugins:
        return cast("Planner | PickingSampler", plugins[name].load()())
    every = ["auto", *names()]
    meant = near(str(name), every)
    advice = f"{meant} use one of: {', '.join(every)}".lstrip()
    raise InputError(f"{name!r} is not a backend", field="backend", advice=advice)


def get_planner(name: str) -> Planner:
    """Return a planner by name."""
    backend = get(name)
    assert isinstance(backend, Planner)
    return backend


def capabilities(name: str) -> Capabilities:
    """Return what a backend declares about itself."""
    return get(name).capabilities


def extra_for(name: str) -> str | None:
    """Return the extra that installs a backend of ours; None: the base does."""
    return extra_of(BUILTIN[name][2]) if name in BUILTIN else None
