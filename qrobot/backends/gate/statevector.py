"""QAOA in the penalty form on any model, simulated exactly and without any SDK."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from qrobot.backends.base import Capabilities
from qrobot.backends.gate import resources
from qrobot.backends.gate.form import Form, bits_of
from qrobot.backends.gate.resources import few_threads
from qrobot.backends.gate.search import lengths
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.backends.gate.tune import Tuning, tune
from qrobot.backends.sampler import (
    COMMON,
    Parameter,
    PickingSampler,
    constant_samples,
    samples_of_bits,
)
from qrobot.errors import InputError

__all__ = ["StatevectorSampler"]


class StatevectorSampler(PickingSampler):
    """Samples the QAOA state of a binary quadratic model.

    Angles are searched first (`qrobot.backends.gate.tune`), then the final state is sampled:
    nothing is repaired. What the state says by itself is in the sample set's `info`:
    ``gammas``, ``betas``, ``objective``, ``evaluations``, ``history``, ``ground_energy`` (the
    least energy of any assignment), ``ground_probability`` and, as the control,
    ``ground_probability_uniform``, and ``timing`` in seconds.
    """

    name = "statevector"
    capabilities = Capabilities(kind="sampler", max_size=26)

    accepts: Mapping[str, Parameter] = {
        **COMMON,
        "num_reads": Parameter("whole", 1, optional=False),
        "layers": Parameter("whole", 1, 1000, optional=False),
        "alpha": Parameter("number", 0, 1, above=True, optional=False),
        "evaluations": Parameter("whole", 0, optional=False),
        "gammas": Parameter("numbers"),
        "betas": Parameter("numbers"),
        "precision": Parameter("choice", choices=("double", "single"), optional=False),
        "threads": Parameter("whole", 1, 256),
        "engine": Parameter("choice", choices=("auto", "numba", "numpy"), optional=False),
    }
    properties: ClassVar[dict[str, Any]] = {"simulates": "qaoa"}

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:  # noqa: ARG002
        """Return sampling parameters that suit a picking model.

        Parameters
        ----------
        largest_distance
            Not needed: angles are searched in units of the spread of the energies.
        """
        return {"alpha": 0.1}

    def sample(
        self,
        bqm: Any,
        *,
        num_reads: int = 1000,
        seed: int | None = None,
        layers: int = 1,
        alpha: float = 1.0,
        evaluations: int = 40,
        gammas: Sequence[float] | None = None,
        betas: Sequence[float] | None = None,
        precision: str = "double",
        threads: int | None = 1,
        engine: str = "auto",
        interrupt_function: Callable[[], bool] | None = None,
    ) -> Any:
        """Sample a model.

        Parameters
        ----------
        bqm
            Any `dimod.BinaryQuadraticModel`; up to 26 variables are quick, memory sets the end.
        num_reads
            Shots from the final state.
        seed
            Of the shots; the search for angles is deterministic.
        layers
            Number of QAOA layers p.
        alpha
            1 minimises the expectation, less the mean of the best share (CVaR).
        evaluations
            Most runs of the circuit in the search; 0 takes the given angles, or those that
            are best for one layer in closed form.
        gammas, betas
            Angles to begin with, one of each a layer.
        precision
            ``double`` or ``single`` (half the memory).
        threads
            Threads of compiled code; ``None``: all cores.
        engine
            ``auto``, ``numba`` or ``numpy``.
        interrupt_function
            Asked before every run of the circuit and between parts of the shots; True ends the
            search with the best angles so far, and the shots after a part of them.

        Returns
        -------
        dimod.SampleSet
            One row a shot.

        Raises
        ------
        BackendError
            When the state does not fit into memory; nothing was allocated.
        InputError
            When the model holds NaN or infinity, or an option is out of range.
        """
        if (gammas is None) != (betas is None):
            raise InputError("gammas and betas come together", field="betas")
        clock = [time.perf_counter()]
        what = f"holding the state and the energies of {bqm.num_variables} qubits (at least)"
        # Before the couplings are a matrix.
        resources.require(12 << bqm.num_variables, what, qubits=bqm.num_variables)
        form = Form.from_bqm(bqm)
        if not form.qubits:
            return constant_samples(bqm, num_reads)
        qaoa = DiagonalQAOA(form, precision=precision, threads=threads, engine=engine, alpha=alpha)
        clock.append(time.perf_counter())
        start = None if gammas is None or betas is None else (list(gammas), list(betas))
        with few_threads(form.qubits) if threads == 1 else nullcontext():
            found = tune(
                qaoa, layers, evaluations=evaluations, start=start, stop=interrupt_function
            )
            clock.append(time.perf_counter())
            qaoa.run(found.gammas, found.betas)
        clock.append(time.perf_counter())
        indices = _drawn(qaoa, num_reads, np.random.default_rng(seed), interrupt_function)
        clock.append(time.perf_counter())
        info = _info(qaoa, found, clock)
        if len(indices) < num_reads:
            info["cut"] = (
                f"the sampler's share of the time was up: the search for angles ended after "
                f"{found.evaluations} runs, and {len(indices)} of {num_reads} reads were taken"
            )
        return samples_of_bits(bqm, bits_of(indices, form.qubits), info)


def _drawn(
    qaoa: DiagonalQAOA,
    num_reads: int,
    rng: np.random.Generator,
    interrupted: Callable[[], bool] | None,
) -> npt.NDArray[np.int64]:
    """Return shots, a quarter at a time: as many as there was time for."""
    parts = np.diff(np.linspace(0, num_reads, 5).astype(int)) if num_reads > 4 else [num_reads]
    drawn = []
    for part in parts:
        drawn.append(qaoa.sample(int(part), rng))
        if interrupted is not None and interrupted():
            break
    return np.concatenate(drawn)


def _info(qaoa: DiagonalQAOA, found: Tuning, clock: list[float]) -> dict[str, Any]:
    objective = qaoa.expectation() if qaoa.alpha == 1.0 else qaoa.cvar()
    return {
        "gammas": list(found.gammas),
        "betas": list(found.betas),
        "objective": objective,
        "alpha": qaoa.alpha,
        "evaluations": found.evaluations,
        "history": list(found.history),
        "ground_energy": qaoa.lowest,
        "ground_probability": float(qaoa.probabilities(qaoa.ground).sum()),
        "ground_probability_uniform": qaoa.ground.size / qaoa.diagonal.size,
        "qubits": qaoa.qubits,
        "engine": qaoa.engine.name,
        "timing": lengths(("build", "search", "run", "sample"), clock),
    }
