"""What a variational sampler tells of a run, as plain data."""

from __future__ import annotations

from typing import Any

from qrobot._arrays import Floats
from qrobot.backends.gate.engine import Engine
from qrobot.backends.gate.optimisers import Found
from qrobot.backends.gate.search import Search

__all__ = ["facts_of", "ground", "lengths"]


def lengths(names: tuple[str, ...], clock: list[float]) -> dict[str, float]:
    """Return the seconds between the instants of a clock, by name."""
    return {name: b - a for name, a, b in zip(names, clock, clock[1:], strict=False)}


def facts_of(
    search: Search, seed: int, engine: Engine, trainer: Engine, found: Found
) -> dict[str, Any]:
    """Return the info of a sample set; `VariationalSampler` says what is in it."""
    return {
        "algorithm": search.algorithm,
        "ansatz": search.ansatz.name,
        "layers": search.options.layers,
        "alpha": search.alpha,
        "optimizer": search.optimizer,
        "qubits": search.form.qubits,
        "parameters": [float(value) for value in found.parameters],
        "objective": found.value if found.history else None,
        "history": found.history,
        "evaluations": len(found.history),
        "searches": found.searches,
        "executions": engine.executions + (trainer.executions if trainer is not engine else 0),
        "trained": "device" if trainer is engine else "local",
        "seed": seed,
        **engine.facts,
    }


def ground(probabilities: Floats, energies: Floats) -> dict[str, float]:
    """Return what the state says about the least energy, and what a uniform one would."""
    least = float(energies.min())
    spread = float(energies.max()) - least
    ground = energies <= least + 1e-9 * max(spread, abs(least), 1e-300)
    return {
        "ground_energy": least,
        "ground_probability": float(probabilities[ground].sum() / probabilities.sum()),
        "ground_probability_uniform": float(ground.mean()),
    }
