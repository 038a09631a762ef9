"""The base of samplers: a `dimod.Sampler` that also declares `Capabilities`."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import dimod
import numpy as np

from qrobot._arrays import Bits
from qrobot._parameters import Parameter, near
from qrobot.backends.base import Capabilities
from qrobot.errors import InputError
from qrobot.jobs import Estimate
from qrobot.jobs.cost import FREE

__all__ = [
    "COMMON",
    "STARTS",
    "Parameter",
    "PickingSampler",
    "check_finite",
    "check_parameters",
    "constant_samples",
    "samples_of_bits",
]

COMMON: Mapping[str, Parameter] = {
    "num_reads": Parameter("whole", 1),
    "seed": Parameter("whole", 0),
    "interrupt_function": Parameter("function"),
}
"""Parameters that mean the same to every sampler that takes them."""

STARTS = ("random", "tile", "none")
"""How samplers of dwave-samplers fill up missing initial states."""


class PickingSampler(dimod.Sampler):
    """A dimod sampler with a name and declared capabilities.

    Subclasses set `name`, `capabilities`, `accepts` and `properties` and implement
    `sample(bqm, *, num_reads, seed, **parameters)`. They work on any BQM. Whatever calls
    `sample`, the model and the parameters are checked first, the same for all samplers: it
    never sees a name that it does not take, nor a value that `accepts` does not allow.
    """

    name: str
    capabilities: Capabilities
    accepts: Mapping[str, Parameter] = {}
    """What each parameter takes; those of `COMMON` may be left out of it."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "sample" in vars(cls):
            cls.sample = _checked(vars(cls)["sample"])

    @property
    def parameters(self) -> dict[str, list[str]]:
        """Names of what `sample` takes, as dimod wants them."""
        return {name: [] for name in self.accepts}

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


def _checked(sample: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method `sample` that refuses what no sampler can use."""

    @functools.wraps(sample)
    def checked(self: PickingSampler, bqm: Any, *rest: Any, **parameters: Any) -> Any:
        if not isinstance(bqm, dimod.BinaryQuadraticModel):
            raise InputError(
                f"an object of class {type(bqm).__name__} is not a binary quadratic model",
                field="bqm",
                advice=_other_model(bqm),
            )
        check_parameters(self, parameters)
        check_finite(bqm)
        return sample(self, bqm, *rest, **parameters)

    return checked


def _other_model(model: Any) -> str:
    if isinstance(model, dimod.ConstrainedQuadraticModel):
        return "convert it with dimod.cqm_to_bqm"
    if isinstance(model, Mapping):
        return "give a QUBO to sample_qubo, or make a dimod.BinaryQuadraticModel of it"
    return "give a dimod.BinaryQuadraticModel, such as qrobot.models.build_model(instance).bqm"


def check_parameters(
    sampler: PickingSampler, parameters: Mapping[str, Any], *, also: tuple[str, ...] = ()
) -> None:
    """Refuse parameters that a sampler does not take, by their name, type or range.

    Parameters
    ----------
    sampler
        Who shall take them.
    parameters
        What it would be called with.
    also
        Other names that the caller could have meant.

    Raises
    ------
    InputError
        Names the parameter and what is allowed.
    """
    known = sampler.parameters
    if unknown := sorted(set(parameters) - set(known)):
        raise InputError(
            f"backend {sampler.name} takes no option {', '.join(unknown)}",
            field=unknown[0],
            advice=near(unknown[0], [*known, *also]) or f"it takes {', '.join(sorted(known))}",
        )
    declared = {**COMMON, **sampler.accepts}
    for name, value in parameters.items():
        if name in declared:
            declared[name].check(name, value)


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
            advice="check the distances and penalties that it was made from",
        )


def samples_of_bits(
    bqm: dimod.BinaryQuadraticModel, bits: Bits, info: Mapping[str, Any]
) -> dimod.SampleSet:
    """Return rows of 0 and 1, a column for each variable in sequence, as samples of a model."""
    values = bits if bqm.vartype is dimod.BINARY else 2 * bits - 1
    return dimod.SampleSet.from_samples_bqm((values, list(bqm.variables)), bqm, info=dict(info))


def constant_samples(bqm: dimod.BinaryQuadraticModel, num_reads: int) -> dimod.SampleSet:
    """Return the samples of a model without variables: its offset, as often as asked."""
    nothing = np.zeros((num_reads, 0), dtype=np.int8)
    return dimod.SampleSet.from_samples_bqm((nothing, []), bqm)
