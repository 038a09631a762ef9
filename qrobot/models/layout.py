"""Which binary variables a model has, and what each of them means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Bools, Ints
from qrobot.errors import InputError
from qrobot.models.fleet import Vehicles
from qrobot.models.penalties import Encoding

__all__ = ["MAX_VARIABLES", "VariableLayout", "check_size", "layered"]


MAX_VARIABLES = 5_000
"""Larger models are refused: up to 12 million couplings, 400 MB."""


@dataclass(frozen=True, eq=False)
class VariableLayout:
    """The variables of a model: x[t,i,p] first, by robot, step and node; then the slack.

    Parameters
    ----------
    encoding
        Name of the encoding.
    fleet
        The vehicles; vehicle k is called k + 1 in labels, as in the paper.
    items
        Number of items.
    vehicle, step, node
        What each x stands for: vehicle (from 0), step, node (0 is the depot), shape (V,).
    last
        Each vehicle's last step, shape (K,). A vehicle without steps has 0.
    first
        The first step: 0 when the depot's layers are variables, 1 when they are constant.
    slack_vehicle, slack_coefficient
        Of each slack binary, in units of weight, shape (S,).
    summed
        Vehicles with the equation load + slack = M, shape (K,).
    paired
        Vehicles of at most two items, whose capacity is a sum over pairs, shape (K,).
    """

    encoding: Encoding
    fleet: Vehicles
    items: int
    vehicle: Ints
    step: Ints
    node: Ints
    last: Ints
    first: int
    slack_vehicle: Ints
    slack_coefficient: Ints
    summed: Bools
    paired: Bools

    @property
    def places(self) -> int:
        """Number of x variables, V."""
        return len(self.node)

    @property
    def size(self) -> int:
        """Number of variables: the qubits."""
        return len(self.node) + len(self.slack_vehicle)

    @property
    def layers(self) -> Ints:
        """Number of steps that each vehicle has variables for, shape (K,)."""
        return np.where(self.last > 0, self.last - self.first + 1, 0)

    @cached_property
    def labels(self) -> list[str]:
        """Names of the variables: ``x[t,i,p]`` and ``slack[p,b]``; p counts from 1."""
        xs = [
            f"x[{t},{i},{p + 1}]"
            for t, i, p in zip(
                self.step.tolist(), self.node.tolist(), self.vehicle.tolist(), strict=True
            )
        ]
        seen: dict[int, int] = {}
        slack = []
        for p in self.slack_vehicle.tolist():
            seen[p] = seen.get(p, -1) + 1
            slack.append(f"slack[{p + 1},{seen[p]}]")
        return xs + slack

    @cached_property
    def where(self) -> dict[tuple[int, int, int], int]:
        """Index of the variable of (vehicle, step, node)."""
        keys = zip(self.vehicle.tolist(), self.step.tolist(), self.node.tolist(), strict=True)
        return {key: k for k, key in enumerate(keys)}

    @cached_property
    def cell(self) -> Ints:
        """Where each x lies in a grid of shape (K, steps, n + 1), flattened, shape (V,)."""
        steps = self.steps
        return ((self.vehicle * steps + self.step - self.first) * (self.items + 1)) + self.node

    @property
    def steps(self) -> int:
        """Length of the grid's axis of steps: the most layers of any vehicle."""
        return int(self.layers.max(initial=0))


def layered(
    encoding: Encoding,
    fleet: Vehicles,
    items: int,
    *,
    first: int,
    last: Ints,
    allowed: Sequence[Bools],
    slack: Sequence[Ints],
    summed: Bools,
    paired: Bools,
) -> VariableLayout:
    """Make a layout of at most `MAX_VARIABLES` variables, vehicle by vehicle.

    `allowed` has for each vehicle which nodes it may be at, shape (layers, n + 1), `slack` the
    coefficients of its slack; all else is as in `VariableLayout`.
    """
    size = sum(int(a.sum()) for a in allowed) + sum(len(s) for s in slack)
    check_size(size, encoding)
    found = [np.nonzero(a) for a in allowed]
    return VariableLayout(
        encoding=encoding,
        fleet=fleet,
        items=items,
        vehicle=np.repeat(np.arange(len(fleet)), [len(t) for t, _ in found]).astype(np.int64),
        step=_joined([t + first for t, _ in found]),
        node=_joined([i for _, i in found]),
        last=last,
        first=first,
        slack_vehicle=np.repeat(np.arange(len(fleet)), [len(s) for s in slack]).astype(np.int64),
        slack_coefficient=_joined(list(slack)),
        summed=summed,
        paired=paired,
    )


def check_size(size: int, encoding: Encoding) -> None:
    """Refuse a model before anything of its size is allocated."""
    if size > MAX_VARIABLES:
        raise InputError(
            f"the {encoding} model would have {size} binary variables, "
            f"more than the {MAX_VARIABLES} that one model may have",
            field="encoding",
            advice="plan fewer items at a time"
            if encoding == "compact"
            else "use the compact encoding, or plan fewer items at a time",
        )


def _joined(parts: Sequence[npt.NDArray[np.integer]]) -> Ints:
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts]).astype(np.int64)
