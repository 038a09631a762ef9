"""Simulated annealing by `dwave.samplers`.

The distribution `dwave-neal`, whose name this backend keeps, has since 2022 been a shim
over `dwave.samplers.SimulatedAnnealingSampler`; this uses the latter.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import dimod

from qrobot.backends.base import Capabilities
from qrobot.backends.sampler import (
    COMMON,
    STARTS,
    Parameter,
    PickingSampler,
    constant_samples,
)
from qrobot.errors import InputError

__all__ = ["NealSampler"]

SEEDS = 2**31
"""The annealer takes seeds below this."""

SCHEDULES = ("linear", "geometric", "custom")
CRITERIA = ("Metropolis", "Gibbs")

READS = 100
SWEEPS = 2_000
HOT, COLD = 3.0, 50.0
"""Inverse temperatures in units of 1 / largest distance, measured: docs/formulation.md."""


class NealSampler(PickingSampler):
    """Simulated annealing, read by read, on one core.

    Examples
    --------
    >>> import dimod
    >>> bqm = dimod.BinaryQuadraticModel({"a": -1.0}, {}, 0.0, "BINARY")
    >>> NealSampler().sample(bqm, num_reads=2, seed=1).first.sample
    {'a': 1}
    """

    name = "neal"
    capabilities = Capabilities(kind="sampler", max_size=5_000)
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
        "proposal_acceptance_criteria": Parameter("choice", choices=CRITERIA, optional=False),
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
            "num_reads": READS,
            "num_sweeps": SWEEPS,
            "beta_range": [HOT / largest_distance, COLD / largest_distance],
        }

    def sample(
        self,
        bqm: dimod.BinaryQuadraticModel,
        *,
        num_reads: int | None = None,
        num_sweeps: int | None = None,
        num_sweeps_per_beta: int = 1,
        beta_range: Sequence[float] | None = None,
        beta_schedule: Sequence[float] | None = None,
        beta_schedule_type: str = "geometric",
        seed: int | None = None,
        interrupt_function: Callable[[], bool] | None = None,
        initial_states: Any = None,
        initial_states_generator: str = "random",
        randomize_order: bool = False,
        proposal_acceptance_criteria: str = "Metropolis",
    ) -> dimod.SampleSet:
        """Sample low energies of a binary quadratic model.

        Parameters
        ----------
        bqm
            Any model, binary or spin.
        num_reads
            Number of samples; as many as initial states, or 1.
        num_sweeps
            Updates of every variable in a read; 1000.
        num_sweeps_per_beta
            Sweeps at each temperature.
        beta_range
            First and last inverse temperature; guessed from the coefficients.
        beta_schedule, beta_schedule_type
            Inverse temperatures between: ``geometric``, ``linear``, or ``custom`` with the
            schedule itself.
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

        Raises
        ------
        InputError
            When a coefficient is not finite, or a parameter cannot be used.
        """
        from dwave.samplers import SimulatedAnnealingSampler

        if not bqm.num_variables:
            return constant_samples(bqm, num_reads or 1)
        try:
            with warnings.catch_warnings():
                # Without any coefficient every temperature is as good as another.
                warnings.filterwarnings("ignore", "All bqm biases are zero")
                return SimulatedAnnealingSampler().sample(
                    bqm,
                    num_reads=num_reads,
                    num_sweeps=num_sweeps,
                    num_sweeps_per_beta=num_sweeps_per_beta,
                    beta_range=None if beta_range is None else list(beta_range),
                    beta_schedule=beta_schedule,
                    beta_schedule_type=beta_schedule_type,
                    seed=None if seed is None else seed % SEEDS,
                    interrupt_function=interrupt_function,
                    initial_states=initial_states,
                    initial_states_generator=initial_states_generator,
                    randomize_order=randomize_order,
                    proposal_acceptance_criteria=proposal_acceptance_criteria,
                )
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the annealer refused its parameters: {error}",
                field="parameters",
                advice=f"{self.name} takes {', '.join(sorted(self.parameters))}",
            ) from error
