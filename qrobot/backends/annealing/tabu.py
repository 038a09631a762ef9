"""Tabu search by `dwave.samplers`, bounded by work and not by the clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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

__all__ = ["TabuSampler"]

READS = 50
RESTARTS = 10
MOVES = 500


class TabuSampler(PickingSampler):
    """Multistart tabu search on one core.

    `dwave.samplers` ends a read by the clock, which makes a seed useless. Here the clock
    is off: the number of restarts, and of moves in each, end a read. Pass `timeout` to have
    the clock back, and lose repeatability.

    Examples
    --------
    >>> import dimod
    >>> bqm = dimod.BinaryQuadraticModel({"a": -1.0}, {}, 0.0, "BINARY")
    >>> TabuSampler().sample(bqm, seed=1).first.sample
    {'a': 1}
    """

    name = "tabu"
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
    properties: ClassVar[dict[str, Any]] = {"vartypes": ("BINARY", "SPIN")}

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:  # noqa: ARG002
        """Return reads that suit a picking model.

        Parameters
        ----------
        largest_distance
            Largest distance of the instance; tabu search needs no scale of energies.
        """
        return {"num_reads": READS}

    def sample(
        self,
        bqm: dimod.BinaryQuadraticModel,
        *,
        num_reads: int | None = None,
        num_restarts: int = RESTARTS,
        moves: int = MOVES,
        tenure: int | None = None,
        timeout: int | None = None,
        energy_threshold: float | None = None,
        seed: int | None = None,
        interrupt_function: Callable[[], bool] | None = None,
        initial_states: Any = None,
        initial_states_generator: str = "random",
    ) -> dimod.SampleSet:
        """Sample low energies of a binary quadratic model.

        Parameters
        ----------
        bqm
            Any model, binary or spin.
        num_reads
            Number of samples; as many as initial states, or 1.
        num_restarts
            Searches after the first in each read.
        moves
            Moves of each search without the descents in between.
        tenure
            Steps for which a variable stays as it is after a change; a quarter of the
            variables, at most 20.
        timeout
            Milliseconds a read; ``None`` leaves the clock out, so that one seed gives one
            answer.
        energy_threshold
            End a read as soon as this energy is reached.
        seed
            Of every random choice.
        interrupt_function
            Asked after every read; the samples so far are returned when it says True.
        initial_states, initial_states_generator
            Where reads start; ``random``, ``tile`` or ``none`` fills up missing ones.

        Raises
        ------
        InputError
            When a coefficient is not finite, or a parameter cannot be used.
        """
        from dwave.samplers import TabuSampler as Tabu

        if not bqm.num_variables:
            return constant_samples(bqm, num_reads or 1)
        # The library counts the changes that it weighs: as many as variables for a move.
        work = moves * bqm.num_variables
        sampler = Tabu()
        try:
            starts = sampler.parse_initial_states(
                bqm.binary,
                initial_states=initial_states,
                initial_states_generator=initial_states_generator,
                num_reads=num_reads,
                seed=None if seed is None else seed % 2**32,
            )
            seeds = np.random.SeedSequence(seed).generate_state(starts.num_reads)
            reads = []
            for k, number in enumerate(seeds.tolist()):
                reads.append(
                    sampler.sample(
                        bqm,
                        initial_states=starts.initial_states.slice(k, k + 1, sorted_by=None),
                        tenure=tenure,
                        timeout=timeout,
                        num_restarts=num_restarts,
                        energy_threshold=energy_threshold,
                        coefficient_z_first=0,
                        coefficient_z_restart=0,
                        lower_bound_z=work,
                        seed=number,
                    )
                )
                if interrupt_function is not None and interrupt_function():
                    break
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the tabu search refused its parameters: {error}",
                field="parameters",
                advice=f"{self.name} takes {', '.join(sorted(self.parameters))}",
            ) from error
        return dimod.concatenate(reads)
