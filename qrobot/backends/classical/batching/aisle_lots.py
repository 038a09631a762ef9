"""Tours of lots in aisles: shortest ones, compiled. Importing this module imports numba."""

from __future__ import annotations

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot._jit import compile_kernel
from qrobot.backends.base import Routes
from qrobot.backends.classical.orders import Hashes, Trips, lengths_of, masks_of_orders
from qrobot.problem import Instance
from qrobot.warehouse.kernels import Layout, tour_length

__all__ = ["AisleTours"]


def _common(masks: Hashes, lot: int, others: Ints, layout: Layout, lengths: Floats) -> None:
    """Fill in the lengths of shortest tours of one lot with each of some others."""
    for k in range(len(others)):
        lengths[k] = tour_length(masks[lot] | masks[others[k]], layout)


_common = compile_kernel(_common)


class AisleTours:
    """The tour of each lot, a shortest one; see `Tours`."""

    def __init__(self, instance: Instance) -> None:
        self._layout, self._masks = masks_of_orders(instance)
        self._trips = Trips(instance)
        self.lengths: Floats = lengths_of(self._layout, self._masks)

    def common(self, lot: int, others: Ints) -> Floats:
        """Return the length of a shortest tour of a lot with each of some others."""
        lengths = np.empty(len(others))
        _common(self._masks, lot, others, self._layout, lengths)
        return lengths

    def join(self, lot: int, other: int) -> None:
        """Let a lot take in another one."""
        self._masks[lot] |= self._masks[other]
        self.lengths[lot] = tour_length(self._masks[lot], self._layout)

    def routes(self, batches: list[list[int]]) -> Routes:
        """Return the routes of batches of orders, each a shortest tour."""
        return self._trips.routes(map(tuple, batches))
