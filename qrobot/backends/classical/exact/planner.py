"""The planner that proves: subset dynamic programme, or set partition with CP-SAT."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.batching import BatchingPlanner
from qrobot.backends.classical.exact.cover import cheapest_cover, lagrangian
from qrobot.backends.classical.exact.packing import no_packing, no_way
from qrobot.backends.classical.exact.partition import MAX_ELEMENTS, best_split
from qrobot.backends.classical.exact.subsets import (
    Ints,
    Tours,
    count_subsets,
    fitting_subsets,
    shortest_tours,
)
from qrobot.backends.classical.whole import whole_costs
from qrobot.errors import BackendError
from qrobot.problem import Instance

__all__ = ["MAX_ENTRIES", "ExactPlanner"]

MAX_ENTRIES = 6_000_000
"""Entries of the tour table (48 MB): more sets than that are refused."""

MAX_COLUMNS = 150_000
"""More trips than this after pricing are too many for CP-SAT's memory on a small robot."""

FIRST_SHARE, FIRST_ROUNDS = 0.1, 300
"""Of the time, and rounds of ruin and recreate, for a plan to begin with."""

RESOLUTION, LARGEST = 1e9, 2.0**45
"""Units in a usual distance when distances are not whole, and the most that a plan may cost:
CP-SAT's 64 bits hold the sum of all columns."""

ROUNDING = 1e-13
"""Of the largest distance: what sums of distances are rounded by."""


@dataclass(frozen=True, slots=True)
class Columns:
    """Every trip that some robot can carry, at its least length.

    Parameters
    ----------
    masks
        Sets of orders, shape (N,), smallest first.
    loads
        Their weights in units, shape (N,).
    lengths
        Their shortest tours, shape (N,).
    tours, stop_masks, stops
        Held-Karp table over stops, each column's set of stops, and the nodes of each stop.
    """

    masks: Ints
    loads: Ints
    lengths: npt.NDArray[np.float64]
    tours: Tours
    stop_masks: Ints
    stops: tuple[tuple[int, ...], ...]

    def route(self, row: int) -> list[int]:
        """Return the nodes of a column in the sequence of its shortest tour."""
        sequence = self.tours.stops(self.tours.row(int(self.stop_masks[row])))
        return [node for stop in sequence for node in self.stops[stop]]


class ExactPlanner:
    """Exact plans for small instances, with proof.

    All sets of orders that fit on one robot are enumerated, each gets its shortest tour
    (Held and Karp 1962), and the best split over the robots is found by a subset
    convolution (up to 13 orders) or by set partition with CP-SAT. A limit of work limits
    CP-SAT's deterministic time; the enumeration before it is limited by `MAX_ENTRIES`.
    """

    name = "exact"
    capabilities = Capabilities(kind="planner", proves=True, max_size=50)

    def fits(self, instance: Instance) -> bool:
        """Return whether the instance is small enough."""
        try:
            _check_size(instance)
        except BackendError:
            return False
        return True

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: OnBest | None = None,
    ) -> Search:
        """Find and prove the shortest plan; see `Planner.search`.

        Raises
        ------
        BackendError
            When the instance has too many sets of orders that fit on one robot.
        MissingExtraError
            When more than 13 orders need CP-SAT and it is not installed.
        """
        if not instance.orders:
            return Search(routes=[], optimal=True)
        _check_size(instance)
        if start is None and len(instance.orders) > MAX_ELEMENTS:
            # A plan to begin with: it prices most columns out, and is there when time is up.
            left = FIRST_SHARE * stop.remaining if stop.remaining < math.inf else None
            quick = stop.within(left, max_work=FIRST_ROUNDS)
            start = BatchingPlanner().search(instance, stop=quick, seed=seed).routes
            if start is not None and on_best is not None:
                on_best(start, instance.length(start))
        if start is not None and math.isinf(instance.length(start)):
            start = None  # it takes a forbidden way
        columns = _columns(instance, stop)
        if columns is None:
            return Search(routes=start)
        work = len(columns.masks)
        capacities = instance.vehicle_capacities
        if len(instance.orders) <= MAX_ELEMENTS:
            routes, proven = _split(instance, columns, capacities), True
            bound = 0.0
        else:
            routes, proven, bound = _cover(instance, columns, capacities, stop, seed, start)
        if routes is None:
            if proven:
                return Search(infeasible=no_packing(instance), work=work)
            return Search(bound=bound, work=work)
        cost = instance.length(routes)
        if math.isinf(cost):
            reason = no_way(instance) if proven else None
            return Search(bound=bound, infeasible=reason, work=work)
        if on_best is not None:
            on_best(routes, cost)
        return Search(routes=routes, bound=cost if proven else bound, optimal=proven, work=work)


def _check_size(instance: Instance) -> None:
    stops = instance.stops
    limit = MAX_ENTRIES // max(len(stops), 1)
    weights = instance.stop_weights.tolist()
    largest = int(instance.vehicle_capacities.max(initial=0))
    if len(stops) > 50 or count_subsets(weights, largest, limit) >= limit:
        raise BackendError(
            f"backend exact: {len(instance.orders)} orders with {len(stops)} stops have too many"
            f" sets that fit on one robot (more than {limit}); use backend auto or pyvrp"
        )


def _columns(instance: Instance, stop: Stop) -> Columns | None:
    """Return all trips, or None when stopped."""
    stops = instance.stops
    largest = int(instance.vehicle_capacities.max())
    sets, _ = fitting_subsets(instance.stop_weights.tolist(), largest)
    tours = shortest_tours(sets, instance.stop_distances, stop)
    if tours is None:
        return None
    masks, loads = fitting_subsets(instance.order_weights.tolist(), largest)
    stop_masks = np.zeros(len(masks), dtype=np.int64)
    for s, nodes in enumerate(stops):
        owner = int(instance.order_of_node[nodes[0]])
        stop_masks |= ((masks >> owner) & 1) << s
    lengths = tours.lengths[tours.rows(stop_masks)]
    return Columns(masks, loads, lengths, tours, stop_masks, stops)


def _split(
    instance: Instance, columns: Columns, capacities: npt.NDArray[np.int64]
) -> Routes | None:
    # One more trip costs a hair, so that ties in distance go to fewer robots.
    tie = 0.5 / whole_costs(instance, RESOLUTION, len(instance.orders), LARGEST).scale
    tie /= len(instance.orders) + 1
    tie = max(tie, ROUNDING * float(instance.stop_distances.max()))
    tables = []
    for capacity in capacities.tolist():
        fits = columns.loads <= capacity
        table = np.full(1 << len(instance.orders), np.inf)
        table[0] = 0.0
        table[columns.masks[fits]] = columns.lengths[fits] + tie
        tables.append(table)
    total, masks = best_split(tables)
    if not np.isfinite(total):
        return None
    row = {int(mask): i for i, mask in enumerate(columns.masks)}
    return [columns.route(row[mask]) for mask in masks]


def _cover(
    instance: Instance,
    columns: Columns,
    capacities: npt.NDArray[np.int64],
    stop: Stop,
    seed: int,
    start: Routes | None,
) -> tuple[Routes | None, bool, float]:
    """Return routes, whether they (or their absence) are proven, and a lower bound."""
    orders = len(instance.orders)
    total = int(instance.order_weights.sum())
    # The other trips must hold the rest, so a trip cannot be arbitrarily light.
    useful = np.flatnonzero(columns.loads >= total - int(capacities[:-1].sum()))
    whole = whole_costs(instance, RESOLUTION, orders, LARGEST)
    costs = whole.cost(columns.lengths[useful]) + 1
    masks, loads = columns.masks[useful], columns.loads[useful]
    if not len(useful):
        return None, True, np.inf
    upper = np.inf
    if start is not None:
        lengths = np.array([instance.route_length(route) for route in start])
        if lengths.sum() * whole.scale * whole.spread < LARGEST:
            upper = float(whole.cost(lengths).sum() + len(start))
    fewest = int(np.searchsorted(np.cumsum(capacities), total)) + 1
    prices = lagrangian(
        masks, costs.astype(np.float64), orders, (fewest, len(capacities)), upper, stop
    )
    bound = whole.length(prices.bound - len(capacities))
    kept = prices.rows
    if len(kept) > MAX_COLUMNS:
        return start, False, bound
    cover = cheapest_cover(masks[kept], costs[kept], loads[kept], orders, capacities, stop, seed)
    bound = max(bound, whole.length(min(cover.bound, upper) - len(capacities)))
    if cover.rows is None:
        return start, cover.complete, bound
    routes = [columns.route(int(useful[kept[row]])) for row in cover.rows]
    if start is not None and int(costs[kept[cover.rows]].sum()) >= upper:
        routes = start
    return routes, cover.complete, bound
