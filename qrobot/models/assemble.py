"""From a layout to a binary quadratic model, by whole blocks of rows.

With z a row's and w a column's variable, the coefficient of every pair follows from what
the two stand for: same vehicle and next step (a way), same vehicle and step (a robot in
two places), same item (collected twice), same vehicle (load), same order on different
vehicles (split). docs/formulation.md writes the sums out.
"""

from __future__ import annotations

from dataclasses import dataclass

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Bools, Floats
from qrobot.models.layout import VariableLayout
from qrobot.models.penalties import Penalties
from qrobot.models.potentials import Potentials
from qrobot.problem import Instance

__all__ = ["assemble"]


BLOCK = 1_000_000
"""Entries of one block of rows: 8 MB a temporary array."""


@dataclass(frozen=True)
class _Terms:
    """What a model is made of, as arrays over its variables."""

    layout: VariableLayout
    penalties: Penalties
    ways: Floats
    load: Floats
    rooms: Floats
    order: npt.NDArray[np.intp]
    split_costs: bool
    """Whether an order could be split at all, so that this has a penalty."""

    def block(self, rows: slice) -> Floats:
        """Return the pair coefficients of some x rows with all x columns."""
        lay, pen = self.layout, self.penalties
        vehicle, step, node = lay.vehicle, lay.step, lay.node
        mine = (vehicle[rows, None], step[rows, None], node[rows, None])
        same_vehicle = mine[0] == vehicle
        following = same_vehicle & (mine[1] + 1 == step)
        block = np.where(following, self.ways[node[rows]][:, node], 0.0)
        if pen.detour:
            block += pen.detour * (following & (mine[2] == 0) & (node > 0) & (mine[1] > 0))
        block += (2.0 * pen.step) * (same_vehicle & (mine[1] == step))
        block += (2.0 * pen.visit) * ((mine[2] == node) & (node > 0))
        if lay.first == 0:
            ends = (step == 0) | (step == lay.items + 1)
            block += (2.0 * pen.step) * ((mine[1] == step) & ends & (mine[2] + node == 0))
        if self.split_costs:
            order = self.order[node]
            together = (order[rows, None] == order) & (order >= 0) & (mine[2] != node)
            block += pen.same_robot * (together & ~same_vehicle)
        return block + self._capacity(rows, same_vehicle)

    def _capacity(self, rows: slice, same_vehicle: Bools) -> Floats | float:
        lay, weight = self.layout, self.penalties.capacity
        load = self.load[: lay.places]
        block: Floats | float = 0.0
        if lay.summed.any():
            pull = np.where(lay.summed[lay.vehicle], load, 0.0)
            block = (2.0 * weight) * pull[rows, None] * pull * same_vehicle
        if lay.paired.any():
            over = load[rows, None] + load - self.rooms[lay.vehicle]
            apart = (lay.node[rows, None] != lay.node) & (lay.node[rows, None] * lay.node > 0)
            clash = same_vehicle & apart & lay.paired[lay.vehicle] & (over > 0)
            block = block + np.where(clash, weight * over**2, 0.0)
        return block

    def slack_block(self) -> Floats:
        """Return the pair coefficients of all variables with the slack, shape (N, S)."""
        lay = self.layout
        vehicle = np.concatenate([lay.vehicle, lay.slack_vehicle])
        same = vehicle[:, None] == lay.slack_vehicle
        pull = self.load[:, None] * self.load[lay.places :]
        return np.asarray((2.0 * self.penalties.capacity) * pull * same)

    def linear(self) -> Floats:
        """Return the coefficients of single variables, shape (N,)."""
        lay, pen = self.layout, self.penalties
        linear = np.zeros(lay.size)
        x = linear[: lay.places]
        x -= pen.step
        x -= pen.visit * (lay.node > 0)
        if lay.first == 0:
            ends = (lay.step == 0) | (lay.step == lay.items + 1)
            x += pen.step * (1 - 2 * len(lay.fleet)) * (ends & (lay.node == 0))
        else:
            x += np.where(lay.step == lay.first, self.ways[0][lay.node], 0.0)
            x += np.where(lay.step == lay.last[lay.vehicle], self.ways[:, 0][lay.node], 0.0)
        vehicle = np.concatenate([lay.vehicle, lay.slack_vehicle])
        square = self.load * (self.load - 2.0 * self.rooms[vehicle])
        linear += pen.capacity * np.where(lay.summed[vehicle], square, 0.0)
        return linear

    def offset(self, potentials: Potentials) -> float:
        """Return the constant, so that a feasible plan's energy is its distance."""
        lay, pen = self.layout, self.penalties
        driving = lay.layers > 0
        total = pen.step * float(lay.layers.sum()) + pen.visit * lay.items
        if lay.first == 0:
            total += 2.0 * pen.step * len(lay.fleet) ** 2
        total += pen.capacity * float((self.rooms[lay.summed] ** 2).sum())
        both = potentials.leaving + potentials.reaching
        stays = int((lay.layers[driving] + 1).sum()) - lay.items
        return total + float(both[1:].sum()) + float(both[0]) * stays


def assemble(
    instance: Instance, layout: VariableLayout, penalties: Penalties, potentials: Potentials
) -> dimod.BinaryQuadraticModel:
    """Return the model: binary, float64, variables in the layout's order."""
    weights = np.concatenate([[0], instance.weights]).astype(np.float64)
    terms = _Terms(
        layout=layout,
        penalties=penalties,
        ways=potentials.shifted(instance.distances),
        load=np.concatenate([weights[layout.node], layout.slack_coefficient]),
        rooms=layout.fleet.capacities.astype(np.float64),
        order=instance.order_of_node,
        split_costs=len(instance.orders) < instance.size and len(layout.fleet) > 1,
    )
    rows, columns, values = [], [], []
    height = max(1, BLOCK // max(layout.places, 1))
    for top in range(0, layout.places, height):
        block = terms.block(slice(top, top + height))
        r, c = np.nonzero(np.triu(block, top + 1))
        rows.append(r + top)
        columns.append(c)
        values.append(block[r, c])
    if len(layout.slack_vehicle):
        block = terms.slack_block()
        above = np.arange(layout.size)[:, None] < np.arange(layout.places, layout.size)
        r, c = np.nonzero(np.where(above, block, 0.0))
        rows.append(r)
        columns.append(c + layout.places)
        values.append(block[r, c])
    empty = np.zeros(0, dtype=np.intp)
    return dimod.BinaryQuadraticModel.from_numpy_vectors(
        terms.linear(),
        (
            np.concatenate([empty, *rows]),
            np.concatenate([empty, *columns]),
            np.concatenate([np.zeros(0), *values]),
        ),
        terms.offset(potentials),
        dimod.BINARY,
        variable_order=layout.labels,
    )
