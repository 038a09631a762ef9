"""The planner that proves: subset dynamic programme, or set partition with CP-SAT."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.aisles import compiled_soon
from qrobot.backends.classical.batching import BatchingPlanner
from qrobot.backends.classical.exact.columns import MAX_ENTRIES, Columns, check_size, columns_of
from qrobot.backends.classical.exact.cover import cheapest_cover, lagrangian
from qrobot.backends.classical.exact.packing import no_packing, no_schedule, no_way
from qrobot.backends.classical.exact.partition import MAX_ELEMENTS, best_split
from qrobot.backends.classical.exact.scheduling import MOST_STEPS, best_schedule, steps_of
from qrobot.backends.classical.generation import MOST_ORDERS, can_generate, generate
from qrobot.backends.classical.whole import whole_costs
from qrobot.errors import BackendError
from qrobot.plan.dealing import cost
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.problem import Instance

__all__ = ["MAX_ENTRIES", "ExactPlanner"]

MAX_COLUMNS = 150_000
"""More trips than this after pricing are too many for CP-SAT's memory on a small robot."""

FIRST_SHARE, FIRST_ROUNDS = 0.1, 300
"""Of the time, and rounds of ruin and recreate, for a plan to begin with."""

AT_ONCE = 24
"""Tours that are measured between two splits."""

RESOLUTION, LARGEST = 1e9, 2.0**45
"""Units in a usual distance when distances are not whole, and the most that a plan may cost:
CP-SAT's 64 bits hold the sum of all columns."""

ROUNDING = 1e-13
"""Of the largest distance: what sums of distances are rounded by."""


class ExactPlanner:
    """Exact plans for small instances, with proof.

    All sets of orders that fit on one robot are enumerated, each gets its shortest tour
    (Held and Karp 1962; up to 13 orders of several stops only where the split needs it), and
    the best split over the robots is found by a subset convolution (up to 13 orders) or by
    set partition with CP-SAT. Whole orders in aisles are proven by column generation with exact
    tours. A limit of work limits CP-SAT's deterministic time; what is before it is limited by
    numbers of sets and stops.
    """

    name = "exact"
    capabilities = Capabilities(
        kind="planner", proves=True, max_size=50, objectives=("sum", "schedule")
    )

    def fits(self, instance: Instance, stop: Stop | None = None) -> bool:
        """Return whether the instance is small enough, for the time until `stop`."""
        if can_generate(instance) and compiled_soon(stop or Stop()):
            return True
        if instance.routing != "exact":
            return False
        try:
            check_size(instance)
        except BackendError:
            return False
        return True

    def schedules(self, instance: Instance) -> bool:
        """Return whether the best schedule is proven in some seconds."""
        if steps_of(instance) > MOST_STEPS or instance.routing != "exact":
            return False
        try:
            check_size(instance)
        except BackendError:
            return False
        return True

    def at_once(self, instance: Instance) -> bool:
        """Return whether a proof takes no longer than a fraction of a second."""
        if len(instance.orders) > MAX_ELEMENTS or instance.routing != "exact":
            return False
        try:
            return check_size(instance)
        except BackendError:
            return False

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: OnBest | None = None,
        objective: Objective = DISTANCE,
    ) -> Search:
        """Find and prove the cheapest plan; see `Planner.search`.

        Raises
        ------
        BackendError
            When the instance has too many sets of orders that fit on one robot, or more than
            13 orders and an objective that charges robots differently, or some 9 and one that
            counts when trips are made.
        MissingExtraError
            When more than 13 orders need CP-SAT and it is not installed.
        """
        if not instance.orders:
            return Search(routes=[], optimal=True)
        form = objective.form(instance)
        if form == "schedule":
            return _scheduled(instance, objective, stop, start)
        if form == "sum":
            return _charged(instance, objective, stop, start)
        if not self.at_once(instance) and can_generate(instance) and compiled_soon(stop):
            return generate(instance, stop, seed, start, on_best)
        if instance.routing != "exact":
            raise BackendError(
                "backend exact proves plans under a policy where the searches are compiled, for at "
                f"most {MOST_ORDERS} orders: run `qrobot compile`, or use backend batching"
            )
        return _enumerated(instance, stop, seed, start, on_best)


def _enumerated(
    instance: Instance, stop: Stop, seed: int, start: Routes | None, on_best: OnBest | None
) -> Search:
    """Search by the sets of orders that fit on one robot, all listed."""
    shared = check_size(instance)
    if start is None and (len(instance.orders) > MAX_ELEMENTS or not shared):
        # A plan to begin with: it prices most columns out, and is there when time is up.
        left = FIRST_SHARE * stop.remaining if stop.remaining < math.inf else None
        quick = stop.within(left, max_work=FIRST_ROUNDS)
        start = BatchingPlanner().search(instance, stop=quick, seed=seed).routes
        if start is not None and on_best is not None:
            on_best(start, instance.length(start))
    if start is not None and math.isinf(instance.length(start)):
        start = None  # it takes a forbidden way
    columns = columns_of(instance, stop)
    if columns is None:
        return Search(routes=start)
    work = len(columns.masks)
    capacities = instance.vehicle_capacities
    if len(instance.orders) <= MAX_ELEMENTS:
        routes, proven, bound = _split(instance, columns, capacities, stop, start)
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


def _charged(instance: Instance, objective: Objective, stop: Stop, start: Routes | None) -> Search:
    """Search by the subset programme where a metre costs some robots more than others."""
    check_size(instance)
    orders = len(instance.orders)
    if orders > MAX_ELEMENTS:
        raise BackendError(
            f"backend exact proves plans of least {objective.name} with unlike robots for up to "
            f"{MAX_ELEMENTS} orders, these are {orders}; use backend auto"
        )
    columns = columns_of(instance, stop)
    if columns is None:
        return Search(routes=start)
    kinds = Counter(
        kind
        for robot, capacity in zip(instance.robots, instance.capacities.tolist(), strict=True)
        for kind in [(capacity, objective.rate(robot))] * min(robot.trips, orders)
    )
    seats = [kind for kind, count in kinds.items() for _ in range(min(count, orders))]
    capacities, rates = (np.array(column) for column in zip(*seats, strict=True))
    routes, proven, bound = _split(instance, columns, capacities, stop, None, rates)
    work = len(columns.masks)
    if routes is None:
        return Search(routes=start, infeasible=no_packing(instance) if proven else None, work=work)
    bound += objective.fixed(instance)
    return Search(routes=routes, bound=bound, optimal=proven, work=work)


def _scheduled(
    instance: Instance, objective: Objective, stop: Stop, start: Routes | None
) -> Search:
    """Search by labels where it counts how many trips there are, who makes them, or when."""
    check_size(instance)
    orders = len(instance.orders)
    if steps_of(instance) > MOST_STEPS:
        raise BackendError(
            f"backend exact proves schedules of about 9 orders; {orders} orders and "
            f"{len(instance.robots)} robots are too many to prove the least {objective.name}: use "
            "backend auto"
        )
    columns = columns_of(instance, stop)
    if columns is None:
        return Search(routes=start)
    found, proven = best_schedule(instance, columns, objective, stop)
    work = len(columns.masks)
    if found is None:
        reason = no_schedule(instance) if proven else None
        return Search(routes=start, infeasible=reason, work=work)
    value = cost(instance, found.routes, objective, found.seats)
    return Search(found.routes, found.seats, bound=value, optimal=proven, work=work)


def _split(
    instance: Instance,
    columns: Columns,
    capacities: npt.NDArray[np.int64],
    stop: Stop,
    start: Routes | None,
    rates: Floats | None = None,
) -> tuple[Routes | None, bool, float]:
    """Return routes, whether they (or their absence) are proven, and a lower bound.

    With `rates`, what each trip pays for a metre, costs take the place of lengths.

    Where tours are not known yet, their lower bounds take their place; the tours that the
    best split asks for are measured until all of its own are known. No other split is
    shorter then: its tours are no shorter than their bounds.
    """
    # One more trip costs a hair, so that ties in distance go to fewer robots.
    tie = 0.5 / whole_costs(instance, RESOLUTION, len(instance.orders), LARGEST).scale
    tie /= len(instance.orders) + 1
    tie = max(tie, ROUNDING * float(instance.stop_distances.max()))
    if rates is None:
        rates = np.ones(len(capacities))
        charged = False
    else:
        charged = True  # whole distances do not make whole costs, so a hair must be a hair
        tie = ROUNDING * float(instance.stop_distances.max()) * float(rates.min())
    row = {int(mask): i for i, mask in enumerate(columns.masks)}
    known = math.inf if start is None else instance.length(start) + tie * (len(start) - 0.5)
    bound = 0.0
    while True:
        total, masks, before = best_split(_tables(instance, columns, capacities, rates, tie))
        if not np.isfinite(total):
            return None, True, bound
        rows = [row[mask] for mask in masks]
        least = total - tie * len(rows) if charged else float(columns.lengths[rows].sum())
        bound = max(bound, least)
        if columns.known[rows].all():
            return [columns.route(r) for r in rows], True, bound
        if total >= known:
            return start, True, bound
        # Beside the trips of this split those that others as short would ask for.
        others = columns.lengths + before[(1 << len(instance.orders)) - 1 - columns.masks]
        near = np.argsort(np.where(columns.known, np.inf, others), kind="stable")[:AT_ONCE]
        for r in dict.fromkeys([*rows, *near[others[near] < known].tolist()]):
            if columns.known[r]:
                continue
            if stop() or not columns.improve(r, stop):
                return start, False, bound


def _tables(
    instance: Instance,
    columns: Columns,
    capacities: npt.NDArray[np.int64],
    rates: Floats,
    tie: float,
) -> list[npt.NDArray[np.float64]]:
    """Return for each trip what every set of orders costs."""
    tables = []
    for capacity, rate in zip(capacities.tolist(), rates.tolist(), strict=True):
        fits = columns.loads <= capacity
        table = np.full(1 << len(instance.orders), np.inf)
        table[0] = 0.0
        table[columns.masks[fits]] = rate * columns.lengths[fits] + tie
        tables.append(table)
    return tables


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
