"""The base of samplers: a `dimod.Sampler` that also declares `Capabilities`."""

from __future__ import annotations

from typing import Any

import dimod

from qrobot.backends.base import Capabilities

__all__ = ["PickingSampler"]


class PickingSampler(dimod.Sampler):
    """A dimod sampler with a name and declared capabilities.

    Subclasses set `name`, `capabilities`, `parameters` and `properties` and implement
    `sample(bqm, *, num_reads, seed, **parameters)`. They work on any BQM.
    """

    name: str
    capabilities: Capabilities

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return sampling parameters that suit a picking model.

        Parameters
        ----------
        largest_distance
            Largest distance of the instance: the natural scale of energies.
        """
        return {}
