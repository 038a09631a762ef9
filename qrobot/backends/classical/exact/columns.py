"""Every set of orders that some robot can carry, and the shortest tour of each.

Where the sets of *stops* that fit are few enough, one table holds the tours of all of them.
Orders of several stops have few sets of orders but very many sets of stops: then every set of
orders gets a tour of its own, and only those that a best split asks for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Ints
from qrobot.backends.classical.exact.partition import MAX_ELEMENTS
from qrobot.backends.classical.exact.subsets import (
    Tours,
    count_subsets,
    fitting_subsets,
    shortest_tours,
)
from qrobot.backends.classical.exact.tours import MAX_LISTED, MAX_STOPS, shortest_tour, tour_bound
from qrobot.backends.registry import available
from qrobot.errors import BackendError
from qrobot.problem import Instance

__all__ = ["MAX_ENTRIES", "Columns", "check_size", "columns_of"]

MAX_ENTRIES = 6_000_000
"""Entries of the tour table (48 MB): more sets than that are refused."""

MAX_BITS = 50
"""Stops or orders that the bits of a set hold."""

MAX_TOURS = 3_000
"""Sets of orders that get a tour of their own, all before the split."""


@dataclass(slots=True)
class Columns:
    """Every trip that some robot can carry.

    Parameters
    ----------
    masks
        Sets of orders, shape (N,), smallest first.
    loads
        Their weights in units, shape (N,).
    lengths
        Their shortest tours, or lower bounds where `known` is False; shape (N,).
    known
        Whether the length is that of the shortest tour, shape (N,).
    """

    instance: Instance
    masks: Ints
    loads: Ints
    lengths: npt.NDArray[np.float64]
    known: npt.NDArray[np.bool_]
    _tours: Tours | None
    _sequences: dict[int, list[int]]
    _bounded: npt.NDArray[np.bool_]

    def route(self, row: int) -> list[int]:
        """Return the nodes of a column in the sequence of its shortest tour."""
        if self._tours is None:
            sequence = self._sequences[row]
        else:
            mask = sum(1 << s for s in _stops(self.instance, int(self.masks[row])))
            sequence = self._tours.stops(self._tours.row(mask))
        return [node for s in sequence for node in self.instance.stops[s]]

    def improve(self, row: int, stop: Callable[[], bool]) -> bool:
        """Find a column's shortest tour, or first a better bound where that is quicker.

        Returns
        -------
        bool
            False when stopped or given up.
        """
        stops = _stops(self.instance, int(self.masks[row]))
        rows = [0, *(s + 1 for s in stops)]
        d = self.instance.stop_distances[np.ix_(rows, rows)]
        if len(stops) > MAX_LISTED and not self._bounded[row]:
            self._bounded[row] = True
            upper = float(d[:-1, 1:].diagonal().sum() + d[-1, 0])
            self.lengths[row] = max(float(self.lengths[row]), tour_bound(d, upper))
            return True
        found = shortest_tour(d, stop)
        if found is None:
            return False
        self.lengths[row], tour = found
        self._sequences[row] = [stops[v - 1] for v in tour]
        self.known[row] = True
        return True


def _stops(instance: Instance, mask: int) -> list[int]:
    """Return the stops of a set of orders, from 0."""
    owners = instance.order_of_node
    return [s for s, nodes in enumerate(instance.stops) if mask >> int(owners[nodes[0]]) & 1]


def check_size(instance: Instance) -> bool:
    """Return whether one table of tours serves all sets of orders.

    Raises
    ------
    BackendError
        When neither that nor a tour for each set of orders is in reach.
    """
    stops, orders = instance.stops, len(instance.orders)
    largest = int(instance.vehicle_capacities.max(initial=0))
    limit = MAX_ENTRIES // max(len(stops), 1)
    weights = instance.stop_weights.tolist()
    if len(stops) <= MAX_BITS and count_subsets(weights, largest, limit) < limit:
        return True
    most = (1 << MAX_ELEMENTS) if orders <= MAX_ELEMENTS else MAX_TOURS
    lots = instance.order_weights.tolist()
    if orders > MAX_BITS or (sets := count_subsets(lots, largest, most)) >= most:
        raise _too_large(instance, f"more than {most} sets of orders fit on one robot")
    if not instance.whole_orders:
        raise _too_large(instance, f"{sets} sets of orders fit on one robot, too many stops each")
    listed = MAX_STOPS if orders <= MAX_ELEMENTS else MAX_LISTED
    masks, _ = fitting_subsets(lots, largest)
    longest = int((_membership(masks, orders) @ _sizes(instance)).max(initial=0))
    if longest > listed:
        raise _too_large(instance, f"a trip may have {longest} stops, more than {listed}")
    return False


def _too_large(instance: Instance, why: str) -> BackendError:
    # PyVRP cannot keep orders of several stops together.
    others = "pyvrp" if available("pyvrp") and not instance.whole_orders else "batching"
    return BackendError(
        f"backend exact: {len(instance.orders)} orders with {len(instance.stops)} stops are too "
        f"many to prove a plan ({why}); use backend auto or {others}"
    )


def _membership(masks: Ints, orders: int) -> npt.NDArray[np.int64]:
    return (masks[:, None] >> np.arange(orders)) & 1


def _sizes(instance: Instance) -> npt.NDArray[np.int64]:
    """Return how many stops each order has."""
    owners = instance.order_of_node[[nodes[0] for nodes in instance.stops]]
    return np.bincount(owners, minlength=len(instance.orders)).astype(np.int64)


def columns_of(instance: Instance, stop: Callable[[], bool]) -> Columns | None:
    """Return all trips, or None when stopped."""
    largest = int(instance.vehicle_capacities.max())
    shared = check_size(instance)
    masks, loads = fitting_subsets(instance.order_weights.tolist(), largest)
    unknown = np.zeros(len(masks), dtype=bool)
    if shared:
        sets, _ = fitting_subsets(instance.stop_weights.tolist(), largest)
        tours = shortest_tours(sets, instance.stop_distances, stop)
        if tours is None:
            return None
        stop_masks = np.zeros(len(masks), dtype=np.int64)
        for s, nodes in enumerate(instance.stops):
            owner = int(instance.order_of_node[nodes[0]])
            stop_masks |= ((masks >> owner) & 1) << s
        lengths = tours.lengths[tours.rows(stop_masks)]
        return Columns(instance, masks, loads, lengths, ~unknown, tours, {}, ~unknown)
    columns = Columns(
        instance, masks, loads, np.zeros(len(masks)), unknown, None, {}, unknown.copy()
    )
    if len(instance.orders) <= MAX_ELEMENTS:
        return columns
    for row in range(len(masks)):
        if stop() or not columns.improve(row, stop):
            return None
    return columns
