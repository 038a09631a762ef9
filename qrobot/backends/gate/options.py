"""The options that all variational samplers take, checked before anything is built."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.ansatz import ANSATZES
from qrobot.backends.gate.optimisers import OPTIMISERS
from qrobot.backends.sampler import COMMON, Parameter
from qrobot.errors import InputError

__all__ = ["SEARCH", "Options"]


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
