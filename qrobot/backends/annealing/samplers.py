"""The samplers of `dwave.samplers` on this machine: annealing, tabu search, descent.

The distribution `dwave-neal`, whose name the annealer keeps, has since 2022 been a shim over
`dwave.samplers.SimulatedAnnealingSampler`; this uses the latter.
"""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import dimod
import numpy as np

from qrobot.backends.base import Capabilities
from qrobot.backends.sampler import (
    COMMON,
    STARTS,
    Parameter,
    PickingSampler,
    constant_samples,
)
from qrobot.errors import InputError

__all__ = ["DescentSampler", "NealSampler", "TabuSampler"]


class _LocalSampler(PickingSampler):
    """A sampler of the library: one call of it, whose refusals become ours."""

    method: ClassVar[str]
    """What it does, for messages."""

    properties: ClassVar[dict[str, Any]] = {"vartypes": ("BINARY", "SPIN")}

    def sample(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> dimod.SampleSet:
        """Sample low energies of a binary quadratic model.

        Parameters
        ----------
        bqm
            Any model, binary or spin.
        **parameters
            As the class says.

        Raises
        ------
        InputError
            When a coefficient is not finite, or a parameter cannot be used.
        """
        if not bqm.num_variables:
            return constant_samples(bqm, parameters.get("num_reads") or 1)
        try:
            return self._run(bqm, **parameters)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the {self.method} refused its parameters: {error}",
                field="parameters",
                advice=f"{self.name} takes {', '.join(sorted(self.parameters))}",
            ) from error

    @abstractmethod
    def _run(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> dimod.SampleSet: ...


class NealSampler(_LocalSampler):
    """Simulated annealing, read by read, on one core.

    Parameters of `sample`
    ----------------------
    num_reads
        Number of samples; as many as initial states, or 1.
    num_sweeps, num_sweeps_per_beta
        Updates of every variable in a read (1000), and those at each temperature (1).
    beta_range
        First and last inverse temperature; guessed from the coefficients.
    beta_schedule, beta_schedule_type
        Inverse temperatures between: ``geometric``, ``linear``, or ``custom`` with the schedule
        itself.
    seed
        Of every random choice; one seed and one set of parameters give one answer.
    interrupt_function
        Asked after every read; the samples so far are returned when it says True.
    initial_states, initial_states_generator
        Where reads start; ``random``, ``tile`` or ``none`` fills up missing ones.
    randomize_order
        Update variables in random order.
    proposal_acceptance_criteria
        ``Metropolis`` or ``Gibbs``.

    Examples
    --------
    >>> import dimod
    >>> bqm = dimod.BinaryQuadraticModel({"a": -1.0}, {}, 0.0, "BINARY")
    >>> float(NealSampler().sample(bqm, num_reads=2, seed=1).first.energy)
    -1.0
    """

    name, method = "neal", "annealer"
    capabilities = Capabilities(kind="sampler", max_size=5_000)

    SCHEDULES = ("linear", "geometric", "custom")
    HOT, COLD = 3.0, 50.0
    """Inverse temperatures in units of 1 / largest distance, measured: docs/formulation.md."""

    accepts: Mapping[str, Parameter] = {
        **COMMON,
        "num_sweeps": Parameter("whole", 1, 10**8),
        "num_sweeps_per_beta": Parameter("whole", 1, 10**8, optional=False),
        "beta_range": Parameter("numbers", 0, length=2),
        "beta_schedule": Parameter("numbers", 0),
        "beta_schedule_type": Parameter("choice", choices=SCHEDULES, optional=False),
        "initial_states": Parameter("any"),
        "initial_states_generator": Parameter("choice", choices=STARTS, optional=False),
        "randomize_order": Parameter("flag", optional=False),
        "proposal_acceptance_criteria": Parameter(
            "choice", choices=("Metropolis", "Gibbs"), optional=False
        ),
    }
    properties: ClassVar[dict[str, Any]] = {
        "beta_schedule_options": SCHEDULES,
        "vartypes": ("BINARY", "SPIN"),
    }

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return reads, sweeps and a range of temperatures that suit a picking model.

        Parameters
        ----------
        largest_distance
            Largest distance of the instance, d. The annealing starts at temperature d / 3,
            where items change places freely under the measured penalties, and ends at
            d / 50, where a detour of a fiftieth of d is still seen.
        """
        return {
            "num_reads": 100,
            "num_sweeps": 2_000,
            "beta_range": [self.HOT / largest_distance, self.COLD / largest_distance],
        }

    def _run(
        self,
        bqm: dimod.BinaryQuadraticModel,
        *,
        seed: int | None = None,
        beta_range: Sequence[float] | None = None,
        **more: Any,
    ) -> dimod.SampleSet:
        from dwave.samplers import SimulatedAnnealingSampler

        with warnings.catch_warnings():
            # Without any coefficient every temperature is as good as another.
            warnings.filterwarnings("ignore", "All bqm biases are zero")
            return SimulatedAnnealingSampler().sample(
                bqm,
                seed=None if seed is None else seed % 2**31,  # it takes seeds below this
                beta_range=None if beta_range is None else list(beta_range),
                **more,
            )


class TabuSampler(_LocalSampler):
    """Multistart tabu search on one core, bounded by work and not by the clock.

    `dwave.samplers` ends a read by the clock, which makes a seed useless. Here the clock
    is off: the number of restarts, and of moves in each, end a read. Pass `timeout` to have
    the clock back, and lose repeatability.

    Parameters of `sample`
    ----------------------
    num_reads
        Number of samples; as many as initial states, or 1.
    num_restarts
        Searches after the first in each read (10).
    moves
        Moves of each search without the descents in between (500).
    tenure
        Steps for which a variable stays as it is after a change; a quarter of the
        variables, at most 20.
    timeout
        Milliseconds a read; ``None`` leaves the clock out, so that one seed gives one answer.
    energy_threshold
        End a read as soon as this energy is reached.
    seed
        Of every random choice.
    interrupt_function
        Asked after every read; the samples so far are returned when it says True.
    initial_states, initial_states_generator
        Where reads start; ``random``, ``tile`` or ``none`` fills up missing ones.
    """

    name, method = "tabu", "tabu search"
    capabilities = Capabilities(kind="sampler", max_size=5_000)
    accepts: Mapping[str, Parameter] = {
        **COMMON,
        "num_restarts": Parameter("whole", 0, 2**31 - 1, optional=False),
        "moves": Parameter("whole", 1, 10**9, optional=False),
        "tenure": Parameter("whole", 0),
        "timeout": Parameter("whole", 1, 2**31 - 1),
        "energy_threshold": Parameter("number"),
        "initial_states": Parameter("any"),
        "initial_states_generator": Parameter("choice", choices=STARTS, optional=False),
    }

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return reads that suit a picking model; tabu search needs no scale of energies."""
        del largest_distance
        return {"num_reads": 50}

    def _run(
        self,
        bqm: dimod.BinaryQuadraticModel,
        *,
        num_reads: int | None = None,
        num_restarts: int = 10,
        moves: int = 500,
        seed: int | None = None,
        interrupt_function: Callable[[], bool] | None = None,
        initial_states: Any = None,
        initial_states_generator: str = "random",
        timeout: int | None = None,
        **more: Any,
    ) -> dimod.SampleSet:
        from dwave.samplers import TabuSampler as Tabu

        sampler = Tabu()
        starts = sampler.parse_initial_states(
            bqm.binary,
            initial_states=initial_states,
            initial_states_generator=initial_states_generator,
            num_reads=num_reads,
            seed=None if seed is None else seed % 2**32,
        )
        reads = []
        seeds = np.random.SeedSequence(seed).generate_state(starts.num_reads)
        for k, number in enumerate(seeds.tolist()):
            reads.append(
                sampler.sample(
                    bqm,
                    initial_states=starts.initial_states.slice(k, k + 1, sorted_by=None),
                    num_restarts=num_restarts,
                    timeout=timeout,  # the library's own default is a clock
                    coefficient_z_first=0,
                    coefficient_z_restart=0,
                    # It counts the changes that it weighs: as many as variables for a move.
                    lower_bound_z=moves * bqm.num_variables,
                    seed=number,
                    **more,
                )
            )
            if interrupt_function is not None and interrupt_function():
                break
        return dimod.concatenate(reads)


class DescentSampler(_LocalSampler):
    """Steepest descent from random starts: the cheapest sampler, and the control of annealers.

    Every read ends in a local minimum: no single flip improves it. Work units: reads. The
    parameters are those of dwave's ``SteepestDescentSampler``.
    """

    name, method = "descent", "steepest descent"
    capabilities = Capabilities(kind="sampler", max_size=20_000)
    accepts: Mapping[str, Parameter] = {
        "num_reads": COMMON["num_reads"],
        "seed": COMMON["seed"],
        "initial_states": Parameter("any"),
        "initial_states_generator": Parameter("choice", choices=STARTS, optional=False),
        "large_sparse_opt": Parameter("flag", optional=False),
    }

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return a number of reads: descents are cheap, so there are many."""
        del largest_distance
        return {"num_reads": 1000}

    def _run(
        self, bqm: dimod.BinaryQuadraticModel, *, seed: int | None = None, **more: Any
    ) -> dimod.SampleSet:
        from dwave.samplers import SteepestDescentSampler

        seed = None if seed is None else seed % 2**32  # it takes seeds below this
        return SteepestDescentSampler().sample(bqm, seed=seed, **more)
