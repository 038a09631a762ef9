"""The search for parameters: its options, where it begins, by which optimiser, what it tells."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.algorithms import SWEEPS
from qrobot.backends.gate.ansatz import ANSATZES, Ansatz
from qrobot.backends.gate.engine import Engine, StateEngine
from qrobot.backends.gate.form import Form, diagonal
from qrobot.backends.gate.objective import ExactObjective, ShotObjective
from qrobot.backends.gate.optimisers import GRADIENT, OPTIMISERS, Evaluations, Found, minimise
from qrobot.backends.gate.resources import few_threads
from qrobot.backends.sampler import COMMON, Parameter
from qrobot.errors import InputError

__all__ = ["SEARCH", "Options", "ParameterSearch", "facts_of", "ground", "lengths"]


SEARCH: dict[str, Parameter] = {
    **COMMON,
    "num_reads": Parameter("whole", 1, optional=False),
    "ansatz": Parameter("choice", choices=tuple(ANSATZES), optional=False),
    "layers": Parameter("whole", 0, 1000, optional=False),
    "alpha": Parameter("number", 0, 1, above=True),
    "optimizer": Parameter("choice", choices=("auto", *OPTIMISERS), optional=False),
    "evaluations": Parameter("whole", 0),
    "starts": Parameter("whole", 1),
    "initial_parameters": Parameter("numbers"),
    "device": Parameter("any"),
    "device_options": Parameter("names", optional=False),
    "shots": Parameter("whole", 1),
    "train": Parameter("choice", choices=("auto", "device", "local"), optional=False),
}
"""What each of `Options` takes."""


@dataclass(frozen=True, slots=True)
class Options:
    """What a variational sampler is asked for.

    Parameters
    ----------
    num_reads
        Measured shots of the final state.
    seed
        Of the first parameters, of SPSA's directions and of simulated shots.
    ansatz
        ``qaoa``, ``hardware`` or ``problem``.
    layers
        Of the ansatz.
    alpha
        Share of the distribution whose mean is minimised (CVaR); 1 is the mean energy.
        ``None``: 0.05, or the share of 16 assignments where that is more.
    optimizer
        One of `OPTIMISERS`, or ``auto``.
    evaluations
        Most evaluations of the objective in each search for parameters; ``None``: 40 by
        gradients, four passes over all parameters by ``nft``, else 120. 0 searches nothing.
    starts
        Searches from different first parameters, of which the one with the least objective
        is kept. ``None``: 6 for VQE, 1 for QAOA (whose first angles are known) and when
        `initial_parameters` are given.
    initial_parameters
        Begin here (``info["parameters"]`` of an earlier run) and not at the ansatz's own.
    device
        Name of a device, or a device object of the SDK.
    device_options
        Passed to the device when it is made.
    shots
        Shots of each evaluation; ``None`` uses exact probabilities where the device has them.
    train
        Where parameters are searched: ``device``, or ``local`` (an exact simulation on this
        machine, nothing is billed). ``auto``: local devices train themselves, remote ones
        locally.
    interrupt_function
        Called before each evaluation; true ends the search.
    own
        The options that only this SDK has, checked by its sampler.
    """

    num_reads: int = 1000
    seed: int | None = None
    ansatz: str = "hardware"
    layers: int = 1
    alpha: float | None = None
    optimizer: str = "auto"
    evaluations: int | None = None
    starts: int | None = None
    initial_parameters: Sequence[float] | None = None
    device: Any = None
    device_options: dict[str, Any] = field(default_factory=dict)
    shots: int | None = None
    train: str = "auto"
    interrupt_function: Callable[[], bool] | None = None
    own: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check every option.

        Raises
        ------
        InputError
            When one is out of range.
        """
        for name, one in SEARCH.items():
            one.check(name, getattr(self, name))

    def share(self, qubits: int) -> float:
        """Return alpha, or its default for a model of so many variables."""
        if self.alpha is not None:
            return float(self.alpha)
        return max(0.05, 2.0 ** min(0, 4 - qubits))

    def refuse_device_options(self, device: str) -> None:
        """Refuse options for a device that is not made with any.

        Raises
        ------
        InputError
            With their names.
        """
        if self.device_options:
            raise InputError(
                f"{device} takes no options, not {', '.join(map(str, self.device_options))}",
                field="device_options",
                advice="leave them out",
            )

    def first(self, size: int) -> Floats | None:
        """Return the parameters to begin with, shape (size,), when some were given.

        Raises
        ------
        InputError
            When their number is another or one is not finite.
        """
        if self.initial_parameters is None:
            return None
        try:
            given = np.array(list(self.initial_parameters), dtype=np.float64)
        except (TypeError, ValueError):
            given = np.array([np.nan])
        if given.shape != (size,) or not np.isfinite(given).all():
            raise InputError(
                f"{given.size} values are not the {size} finite parameters of the circuit",
                field="initial_parameters",
                advice='use info["parameters"] of a run with the same ansatz, layers and model',
            )
        return given


SHOTS = 1000
"""Of an evaluation on a device that has no exact probabilities."""


class ParameterSearch:
    """A search for the parameters of an ansatz.

    Parameters
    ----------
    algorithm
        ``vqe`` or ``qaoa``.
    options
        What was asked for.
    form, ansatz
        The model, and its circuit.
    seed
        Of everything random.
    """

    def __init__(
        self, algorithm: str, options: Options, form: Form, ansatz: Ansatz, seed: int
    ) -> None:
        self.algorithm, self.options, self.form, self.ansatz = algorithm, options, form, ansatz
        streams = np.random.SeedSequence(seed).spawn(4)
        self.starts = self._starts(np.random.default_rng(streams[0]))
        self._shots, self._ways = streams[1], streams[2]
        self.draw = int(streams[3].generate_state(1)[0] >> 1)
        self.alpha = options.share(form.qubits)
        self.optimizer = options.optimizer
        self.energies: Floats | None = None

    @property
    def shots(self) -> int:
        """Of an evaluation that is measured."""
        return self.options.shots or SHOTS

    def measured(self) -> int:
        """Return the most circuits that a search on a machine without exact states runs."""
        optimizer = self._optimizer(False, False)
        rotations = len(self.ansatz.circuit.rotations)
        each = 2 * rotations + 1 if optimizer in GRADIENT else 1
        most = self._budget(optimizer)
        if optimizer == "none" or not self.ansatz.circuit.size:
            most = min(most, 1)
        return len(self.starts) * most * each

    def run(self, trainer: Engine) -> Found:
        """Search on a device; afterwards `optimizer` and `energies` tell what was used.

        Parameters
        ----------
        trainer
            What evaluates the objective.
        """
        options, objective = self.options, self._objective(trainer)
        self.optimizer = self._optimizer(
            trainer.gradients and options.shots is None, objective.turns is not None
        )
        found = Found(self.starts[0])
        # Here and not only around all: what the device loaded when it was made is held too.
        with few_threads(self.form.qubits):
            for start, stream in zip(self.starts, self._ways.spawn(len(self.starts)), strict=True):
                runs = Evaluations(
                    objective.value,
                    start,
                    budget=self._budget(self.optimizer),
                    slope=objective.slope,
                    turns=objective.turns,
                    interrupted=options.interrupt_function,
                )
                found.join(minimise(self.optimizer, runs, np.random.default_rng(stream)))
        return found

    def _objective(self, trainer: Engine) -> ExactObjective | ShotObjective:
        if isinstance(trainer, StateEngine) and self.options.shots is None:
            self.energies = diagonal(self.form)
            return ExactObjective(trainer, self.energies, self.alpha)
        rng = np.random.default_rng(self._shots)
        return ShotObjective(trainer, self.form, self.alpha, self.shots, rng)

    def _starts(self, rng: np.random.Generator) -> list[Floats]:
        """Return first parameters: the given ones, or one's own for each start."""
        options, ansatz = self.options, self.ansatz
        given = options.first(ansatz.circuit.size)
        count = options.starts or (1 if given is not None or self.algorithm == "qaoa" else 6)
        if given is None:
            return [ansatz.start(rng) for _ in range(count)]
        return [given, *(given + rng.normal(0.0, 0.1, given.size) for _ in range(count - 1))]

    def _optimizer(self, gradients: bool, turns: bool) -> str:
        if self.options.optimizer != "auto":
            return self.options.optimizer
        if self.algorithm == "qaoa":
            return "cobyla"
        if gradients:
            return "adam"
        return "nft" if turns else "spsa"

    def _budget(self, optimizer: str) -> int:
        if self.options.evaluations is not None:
            return self.options.evaluations
        if optimizer == "nft":
            return SWEEPS * (2 * self.ansatz.circuit.size + 1)
        return 40 if optimizer in GRADIENT else 120


def lengths(names: tuple[str, ...], clock: list[float]) -> dict[str, float]:
    """Return the seconds between the instants of a clock, by name."""
    return {name: b - a for name, a, b in zip(names, clock, clock[1:], strict=False)}


def facts_of(
    search: ParameterSearch, seed: int, engine: Engine, trainer: Engine, found: Found
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
