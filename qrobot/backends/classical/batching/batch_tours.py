"""The tours of batches that a search asks for again and again, each found once."""

from __future__ import annotations

from qrobot.backends.base import Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.backends.classical.batching.lots import StopTours
from qrobot.plan.timing import TimedRoute, timed
from qrobot.problem import Instance

__all__ = ["Batch", "BatchTours"]

Batch = tuple[int, ...]
"""Its orders, rising."""

MOST_KEPT = 200_000
"""Batches that are remembered: some 100 MB."""


class BatchTours:
    """Lengths and routes of batches: shortest tours in aisles, otherwise improved ones.

    Parameters
    ----------
    instance
        The question.
    stop
        When improving leaves off; where little time is left, compiled kernels are not loaded.
    """

    def __init__(self, instance: Instance, stop: Stop) -> None:
        self._instance = instance
        self._timed: dict[Batch, TimedRoute] = {}
        self._routes: dict[Batch, list[int]] = {}
        self._exact = takes(instance) and compiled_soon(stop)
        if self._exact:
            from qrobot.backends.classical import orders  # loads numba

            self._layout, self._masks = orders.masks_of_orders(instance)
            self._trips = orders.Trips(instance)
            self._length_of = orders.lengths_of
        else:
            self._tours = StopTours(instance, stop)

    def keep(self, batch: Batch, route: list[int]) -> None:
        """Remember a route that is known already."""
        if not self._exact:
            self._routes[batch] = route

    def timed(self, batch: Batch) -> TimedRoute:
        """Return length and times of a batch."""
        known = self._timed.get(batch)
        if known is None:
            if len(self._timed) > MOST_KEPT:
                self._timed.clear()
            nodes = [node for o in batch for node in self._instance.order_nodes[o]]
            if self._exact:
                together = self._masks[list(batch)]
                words = together[:1].copy()
                for more in together[1:]:
                    words |= more
                known = timed(self._instance, nodes, float(self._length_of(self._layout, words)[0]))
            else:
                known = timed(self._instance, self.route(batch))
            self._timed[batch] = known
        return known

    def route(self, batch: Batch) -> list[int]:
        """Return the nodes of a batch in sequence."""
        if self._exact:
            return self._trips.routes([batch])[0]
        if batch not in self._routes:
            (self._routes[batch],) = self._instance.in_sequence(self._tours.routes([list(batch)]))
        return self._routes[batch]
