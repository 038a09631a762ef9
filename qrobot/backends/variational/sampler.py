"""The sampler that the three SDKs share: search parameters, then measure, and say both."""

from __future__ import annotations

import time
from abc import abstractmethod
from typing import Any, ClassVar

import dimod
import numpy as np
import numpy.typing as npt

from qrobot.backends.base import Capabilities
from qrobot.backends.gates.form import Form, diagonal
from qrobot.backends.sampler import PickingSampler, check_finite, constant_samples
from qrobot.backends.variational.ansatz import Ansatz, make_ansatz
from qrobot.backends.variational.engine import Engine, PlainEngine, StateEngine, room
from qrobot.backends.variational.ising import terms
from qrobot.backends.variational.objective import ExactObjective, Objective, ShotObjective
from qrobot.backends.variational.optimisers import GRADIENT, Found, minimise
from qrobot.backends.variational.options import Options
from qrobot.errors import BackendError, InputError

__all__ = ["VariationalSampler", "failed"]

Floats = npt.NDArray[np.float64]

SHOTS = 1000
"""Of an evaluation on a device that has no exact probabilities."""


class VariationalSampler(PickingSampler):
    """Searches a circuit's parameters and samples its final state.

    Reads are measured shots as they come: nothing is repaired or selected. The sample set's
    `info` holds ``parameters`` (to resume from), ``objective``, ``history`` (the objective of
    each evaluation), ``evaluations``, ``searches`` (evaluations of each start),
    ``executions`` (circuits run), ``ansatz``, ``layers``,
    ``alpha``, ``optimizer``, ``device``, ``trained``, ``qubits``, ``seed``, ``timing`` in
    seconds and, where probabilities are exact, ``ground_energy``, ``ground_probability`` and
    the control ``ground_probability_uniform``.
    """

    sdk: ClassVar[str]
    algorithm: ClassVar[str]
    extra: ClassVar[str]
    own: ClassVar[tuple[str, ...]] = ()
    """Names of the options that only this SDK has."""

    properties: ClassVar[dict[str, Any]] = {}

    def __init__(self) -> None:
        self.name = f"{self.sdk}-{self.algorithm}"
        # No largest size: the device and the memory decide, before anything is allocated.
        self.capabilities = Capabilities(kind="sampler", extra=self.extra)

    @property
    def parameters(self) -> dict[str, list[str]]:
        """Names of what `sample` takes, as dimod wants them."""
        names = [*Options.names(), *self.own]
        if self.algorithm == "qaoa":
            names.remove("ansatz")
        return {name: [] for name in names}

    @abstractmethod
    def check(self, qubits: int, options: Options, own: dict[str, Any]) -> bool:
        """Refuse what the device cannot do, before anything is allocated.

        Returns
        -------
        bool
            Whether the device is local (nothing is billed).

        Raises
        ------
        MissingExtraError
            When the SDK is absent.
        BackendError
            When there are too many qubits, or the device is no more.
        """

    @abstractmethod
    def engine(self, ansatz: Ansatz, options: Options, own: dict[str, Any]) -> Engine:
        """Return the device, ready to run the ansatz."""

    def sample(self, bqm: Any, **parameters: Any) -> dimod.SampleSet:
        """Sample a binary quadratic model; parameters as of `Options`.

        Raises
        ------
        InputError
            When an option is unknown or out of range, or the model holds NaN.
        BackendError
            When the model does not fit, or the device fails.
        """
        unknown = sorted(set(parameters) - set(self.parameters))
        if unknown:
            raise InputError(
                f"backend {self.name} takes no option {', '.join(unknown)}",
                field="backend",
                mend=f"it takes {', '.join(sorted(self.parameters))}",
            )
        own = {name: parameters.pop(name) for name in self.own if name in parameters}
        if self.algorithm == "qaoa":
            parameters["ansatz"] = "qaoa"
        options = Options(**parameters)
        check_finite(bqm)
        qubits = bqm.num_variables
        local = self.check(qubits, options, own)
        if not qubits:
            return constant_samples(bqm, int(options.num_reads))
        return self._run(bqm, options, own, local)

    def _run(self, bqm: Any, options: Options, own: dict[str, Any], local: bool) -> dimod.SampleSet:
        began = time.perf_counter()
        seed = _fresh() if options.seed is None else int(options.seed)
        streams = np.random.SeedSequence(seed).spawn(4)
        form = Form.from_bqm(bqm)
        ansatz = make_ansatz(options.ansatz, form, terms(bqm), options.layers)
        starts = self._starts(options, ansatz, np.random.default_rng(streams[0]))
        engine = self.engine(ansatz, options, own)
        here = options.train == "device" or (local and options.train == "auto")
        trainer = engine if here or options.evaluations == 0 else _trainer(ansatz)
        energies: Floats | None = None
        if isinstance(trainer, StateEngine) and options.shots is None:
            energies = diagonal(form)
        built = time.perf_counter()
        rng = np.random.default_rng(streams[1])
        alpha = options.share(form.qubits)
        objective: Objective
        if energies is not None and isinstance(trainer, StateEngine):
            objective = ExactObjective(trainer, energies, alpha)
        else:
            shots = options.shots or SHOTS
            objective = ShotObjective(trainer, form, alpha, shots, rng)
        optimizer = self._optimizer(options, trainer)
        budget = options.evaluations
        if budget is None:
            budget = 40 if optimizer in GRADIENT else 120
        found = Found(starts[0])
        for start, stream in zip(starts, streams[2].spawn(len(starts)), strict=True):
            found.join(
                minimise(
                    optimizer,
                    objective.value,
                    objective.slope,
                    start,
                    budget=budget,
                    rng=np.random.default_rng(stream),
                    interrupted=options.interrupt_function or (lambda: False),
                )
            )
        trained = time.perf_counter()
        angles = ansatz.circuit.angles(found.parameters)
        draw = int(streams[3].generate_state(1)[0] >> 1)
        bits = engine.samples(angles, options.num_reads, draw)
        sampled = time.perf_counter()
        info = self._info(options, ansatz, engine, trainer, found, optimizer) | {
            "seed": seed,
            "timing": {
                "build": built - began,
                "optimise": trained - built,
                "sample": sampled - trained,
            },
        }
        if isinstance(engine, StateEngine) and energies is not None:
            info |= _ground(engine.probabilities(angles), energies)
        values = bits if bqm.vartype is dimod.BINARY else 2 * bits - 1
        return dimod.SampleSet.from_samples_bqm(
            (values.astype(np.int8), list(form.variables)), bqm, info=info
        )

    def _starts(self, options: Options, ansatz: Ansatz, rng: np.random.Generator) -> list[Floats]:
        """Return first parameters: the given ones, or one's own for each start."""
        given = options.first(ansatz.circuit.size)
        count = options.starts or (1 if given is not None or self.algorithm == "qaoa" else 6)
        if given is None:
            return [ansatz.start(rng) for _ in range(count)]
        return [given, *(given + rng.normal(0.0, 0.1, given.size) for _ in range(count - 1))]

    def _optimizer(self, options: Options, engine: Engine) -> str:
        if options.optimizer != "auto":
            return options.optimizer
        if self.algorithm == "qaoa":
            return "cobyla"
        return "adam" if engine.gradients and options.shots is None else "spsa"

    def _info(
        self,
        options: Options,
        ansatz: Ansatz,
        engine: Engine,
        trainer: Engine,
        found: Found,
        optimizer: str,
    ) -> dict[str, Any]:
        return {
            "algorithm": self.algorithm,
            "ansatz": ansatz.name,
            "layers": options.layers,
            "alpha": options.share(ansatz.circuit.qubits),
            "optimizer": optimizer,
            "qubits": ansatz.circuit.qubits,
            "parameters": [float(value) for value in found.parameters],
            "objective": found.value if found.history else None,
            "history": found.history,
            "evaluations": len(found.history),
            "searches": found.searches,
            "executions": engine.executions + (trainer.executions if trainer is not engine else 0),
            "trained": "device" if trainer is engine else "local",
            **engine.facts,
        }


def _trainer(ansatz: Ansatz) -> Engine:
    room(
        ansatz.circuit.qubits,
        "this machine, where parameters are searched",
        "use train='device', or evaluations=0 with initial_parameters",
    )
    return PlainEngine(ansatz.circuit)


def _ground(probabilities: Floats, energies: Floats) -> dict[str, float]:
    """Return what the state says about the least energy, and what a uniform one would."""
    least = float(energies.min())
    spread = float(energies.max()) - least
    ground = energies <= least + 1e-9 * max(spread, abs(least), 1e-300)
    return {
        "ground_energy": least,
        "ground_probability": float(probabilities[ground].sum() / probabilities.sum()),
        "ground_probability_uniform": float(ground.mean()),
    }


def _fresh() -> int:
    return int(np.random.SeedSequence().generate_state(1)[0])


def failed(name: str, doing: str, error: BaseException) -> BackendError:
    """Return a refusal that names the kind of an SDK's error, never its text.

    Texts of remote SDKs may quote a token or a signed address.
    """
    return BackendError(f"backend {name}: {doing} failed ({type(error).__name__})")
