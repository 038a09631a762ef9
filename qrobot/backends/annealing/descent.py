"""Steepest descent: the cheapest sampler, and the control that annealers must beat."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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

__all__ = ["DescentSampler"]

SEEDS = 2**32
"""dwave-samplers takes seeds below this one."""


class DescentSampler(PickingSampler):
    """Steepest descent from random starts on this machine. Work units: reads.

    Every read ends in a local minimum: no single flip improves it.
    """

    name = "descent"
    capabilities = Capabilities(kind="sampler", max_size=20_000)

    accepts: Mapping[str, Parameter] = {
        "num_reads": COMMON["num_reads"],
        "seed": COMMON["seed"],
        "initial_states": Parameter("any"),
        "initial_states_generator": Parameter("choice", choices=STARTS, optional=False),
        "large_sparse_opt": Parameter("flag", optional=False),
    }

    def __init__(self) -> None:
        from dwave.samplers import SteepestDescentSampler

        self._sampler = SteepestDescentSampler()

    @property
    def properties(self) -> dict[str, Any]:
        """What dwave-samplers says about itself."""
        return dict(self._sampler.properties)

    def sample(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> dimod.SampleSet:
        """Sample a model; parameters as of dwave's SteepestDescentSampler.

        Raises
        ------
        InputError
            When a coefficient is not finite, or a parameter cannot be used.
        """
        if not bqm.num_variables:
            return constant_samples(bqm, parameters.get("num_reads") or 1)
        if isinstance(seed := parameters.get("seed"), int):
            parameters["seed"] = seed % SEEDS
        try:
            return self._sampler.sample(bqm, **parameters)
        except (TypeError, ValueError) as error:
            raise InputError(f"steepest descent refused its parameters: {error}") from None

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return a number of reads: descents are cheap, so there are many."""
        del largest_distance
        return {"num_reads": 1000}
