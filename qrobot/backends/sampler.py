"""The base of samplers: a `dimod.Sampler` that also declares `Capabilities`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import dimod
import numpy as np

from qrobot.backends.base import Capabilities
from qrobot.errors import InputError
from qrobot.remote import Estimate
from qrobot.remote.cost import FREE

__all__ = [
    "PickingSampler",
    "check_finite",
    "check_known",
    "check_share",
    "check_whole",
    "constant_samples",
]


class PickingSampler(dimod.Sampler):
    """A dimod sampler with a name and declared capabilities.

    Subclasses set `name`, `capabilities`, `parameters` and `properties` and implement
    `sample(bqm, *, num_reads, seed, **parameters)`. They work on any BQM.
    """

    name: str
    capabilities: Capabilities

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:  # noqa: ARG002
        """Return sampling parameters that suit a picking model.

        Parameters
        ----------
        largest_distance
            Largest distance of the instance: the natural scale of energies.
        """
        return {}

    def runs_remotely(self, **parameters: Any) -> bool:  # noqa: ARG002
        """Return whether `sample` with these parameters asks another machine."""
        return not self.capabilities.local

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:  # noqa: ARG002
        """Return what a sample would cost; submits nothing that bills."""
        if self.runs_remotely(**parameters):
            return Estimate(None, None, f"backend {self.name} tells no price")
        return FREE


def check_finite(bqm: dimod.BinaryQuadraticModel) -> None:
    """Refuse a model that no sampler can make sense of.

    Raises
    ------
    InputError
        When a coefficient is not a finite number; names the first one.
    """
    labels = list(bqm.variables)
    linear, (rows, columns, quadratic), offset = bqm.to_numpy_vectors(variable_order=labels)
    linear = np.asarray(linear, dtype=np.float64)
    quadratic = np.asarray(quadratic, dtype=np.float64)
    where = ""
    if not np.isfinite(linear).all():
        where = f"of {labels[int(np.argmin(np.isfinite(linear)))]!r} "
    elif not np.isfinite(quadratic).all():
        k = int(np.argmin(np.isfinite(quadratic)))
        where = f"of {labels[int(rows[k])]!r} with {labels[int(columns[k])]!r} "
    elif not np.isfinite(float(offset)):
        where = "of the offset "
    if where:
        raise InputError(
            f"the coefficient {where}is not a finite number",
            field="bqm",
            mend="check the distances and penalties that it was made from",
        )


def constant_samples(bqm: dimod.BinaryQuadraticModel, num_reads: int) -> dimod.SampleSet:
    """Return the samples of a model without variables: its offset, as often as asked."""
    nothing = np.zeros((num_reads, 0), dtype=np.int8)
    return dimod.SampleSet.from_samples_bqm((nothing, []), bqm)


def check_known(sampler: PickingSampler, options: Iterable[str]) -> None:
    """Refuse options that a sampler does not take.

    Raises
    ------
    InputError
        With their names, and those that it takes.
    """
    if unknown := sorted(set(options) - set(sampler.parameters)):
        raise InputError(
            f"backend {sampler.name} takes no option {', '.join(unknown)}",
            field="backend",
            mend=f"it takes {', '.join(sorted(sampler.parameters))}",
        )


def check_whole(name: str, value: Any, least: int) -> None:
    """Refuse an option that is no whole number of `least` or more.

    Raises
    ------
    InputError
        With the option's name.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise InputError(
            f"{value!r} is not a whole number of {least} or more", field=name, mend="correct it"
        )


def check_share(name: str, value: Any) -> None:
    """Refuse an option that is no share: above 0 and at most 1.

    Raises
    ------
    InputError
        With the option's name.
    """
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not 0.0 < float(value) <= 1.0:
        raise InputError(f"{value!r} is not a share", field=name, mend=f"use 0 < {name} <= 1")
