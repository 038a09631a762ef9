"""PyVRP: iterated local search for vehicle routing (Wouda, Lan and Kool 2024)."""

from __future__ import annotations

import time
import warnings
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from qrobot._extras import load
from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.whole import usual_distance, whole_costs
from qrobot.errors import BackendError
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.problem import Instance

if TYPE_CHECKING:
    import pyvrp

__all__ = ["PlainPyVRPPlanner", "PyVRPPlanner"]

RESOLUTION, PLAIN_RESOLUTION, LARGEST = 1e6, 1e4, 2.0**54
"""Units in a usual distance when distances are not whole (coarser under PyVRP's own prices of
overload, which end at 1e5), and the most that a plan may cost: PyVRP adds up 64-bit numbers,
and prices of overload come on top."""

OVERLOAD, MOST_OVERLOAD = 1.25, 50.0
"""First price of overloading a trip by a mean weight, in usual distances, and the highest, in
largest distances: what is far off must not be worth an overload."""


RATES, DEAREST = 100, 1e4
"""Units in the lowest price of a metre where prices differ, and the most times that of it."""

MANY = 200
"""Stops beyond which a start is improved everywhere before any part is perturbed."""

FIRST_SHARE = 6.0
"""The first local search takes this many times as long as building the data, at most."""


class PyVRPPlanner:
    """Good plans for any size, without proof.

    PyVRP has no notion of an order that must stay on one trip, so instances with orders of
    several stops are refused. The number of trips is limited to the robots' (PyVRP's own
    reader forgets it). Work units: iterations.
    """

    name = "pyvrp"
    plain = False
    capabilities = Capabilities(kind="planner", whole_orders=False, objectives=("sum",))

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
        """Search until `stop`; see `Planner.search`.

        Raises
        ------
        BackendError
            When an order has several stops.
        MissingExtraError
            When PyVRP is not installed.
        """
        PenaltyBoundWarning = load("pyvrp.exceptions", "backend pyvrp").PenaltyBoundWarning
        from pyvrp.IteratedLocalSearch import IteratedLocalSearchCallbacks

        if instance.whole_orders:
            raise BackendError(
                "backend pyvrp cannot keep orders of several stops together; "
                "use backend auto or batching, or split the orders"
            )
        if not instance.orders:
            return Search(routes=[])
        begun = time.perf_counter()
        data = _problem_data(instance, objective, plain=self.plain)
        first_seconds = FIRST_SHARE * (time.perf_counter() - begun)
        if stop.remaining < first_seconds and len(instance.stops) > MANY:
            # The first step cannot be interrupted.
            return Search(routes=start or instance.first_routes())
        iterations = 0
        found: list[Routes] = []

        def note(solution: pyvrp.Solution) -> None:
            if solution.is_feasible() and solution.is_complete():
                found.append(_routes(instance, solution))
                if on_best is not None:
                    on_best(found[-1], instance.length(found[-1]))
                del found[:-1]

        class Callbacks(IteratedLocalSearchCallbacks):
            def on_best(self, best: pyvrp.Solution) -> None:
                note(best)

        def ended(_: float) -> bool:
            nonlocal iterations
            iterations += 1
            return stop(iterations - 1)

        first = None
        if start is not None:
            first = _solution(instance, data, start)
            found.append(start)
        with warnings.catch_warnings():
            # That feasible plans are rare is no news for tight loads.
            warnings.simplefilter("ignore", PenaltyBoundWarning)
            search = _iterated_search(instance, data, seed, first, Callbacks(), plain=self.plain)
            result = search.run(ended, collect_stats=False, display=False)
        note(result.best)
        return Search(routes=found[-1] if found else None, work=result.num_iterations)


class PlainPyVRPPlanner(PyVRPPlanner):
    """PyVRP with its own default prices of overload, and whole distances as they are.

    A second opinion for the other cores, and the peer that benchmarks compare with.
    """

    name = "pyvrp-plain"
    plain = True


def _problem_data(instance: Instance, objective: Objective, *, plain: bool) -> pyvrp.ProblemData:
    import pyvrp

    vehicles = _vehicles(instance, objective)
    dearest = max(rate for _, rate in vehicles)
    trips = sum(vehicles.values())
    resolution = PLAIN_RESOLUTION if plain else RESOLUTION
    whole = whole_costs(instance, resolution, trips, LARGEST / dearest)
    matrix = whole.cost(instance.stop_distances)
    if plain:
        matrix //= whole.spread
    positions = [
        instance.warehouse.position(instance.items[nodes[0] - 1].place) for nodes in instance.stops
    ]
    return pyvrp.ProblemData(
        locations=[pyvrp.Location(x, y) for x, y in [instance.warehouse.depot, *positions]],
        clients=[
            pyvrp.Client(location=s + 1, delivery=[weight])
            for s, weight in enumerate(instance.stop_weights.tolist())
        ],
        depots=[pyvrp.Depot(location=0)],
        vehicle_types=[
            pyvrp.VehicleType(
                num_available=count,
                capacity=[capacity],
                fixed_cost=0 if plain else 1,
                unit_distance_cost=rate,
            )
            for (capacity, rate), count in sorted(vehicles.items())
        ],
        distance_matrices=[matrix],
        duration_matrices=[np.zeros_like(matrix)],
    )


def _vehicles(instance: Instance, objective: Objective) -> Counter[tuple[int, int]]:
    """Return how many trips there may be of each capacity and each whole price of a metre."""
    if objective.common_rate(instance) is not None:
        return Counter((int(capacity), 1) for capacity in instance.vehicle_capacities)
    least = min(map(objective.rate, instance.robots))
    found: Counter[tuple[int, int]] = Counter()
    for robot, capacity in zip(instance.robots, instance.capacities.tolist(), strict=True):
        price = round(RATES * min(objective.rate(robot) / least, DEAREST))
        found[capacity, price] += min(robot.trips, len(instance.orders))
    return found


def _iterated_search(
    instance: Instance,
    data: pyvrp.ProblemData,
    seed: int,
    first: pyvrp.Solution | None,
    callbacks: Any,
    *,
    plain: bool,
) -> Any:
    """Put PyVRP's own parts together, with a price of overload that suits the units.

    `pyvrp.solve` starts in the middle of a fixed range of prices, which is orders of
    magnitude off for most units, and takes tens of thousands of rounds to come down.
    """
    import pyvrp
    import pyvrp.search as parts
    from pyvrp.IteratedLocalSearch import IteratedLocalSearch, IteratedLocalSearchParams

    rng = pyvrp.RandomNumberGenerator(seed=seed % 2**31)
    local = parts.LocalSearch(
        data,
        rng,
        parts.compute_neighbours(data),
        parts.PerturbationManager(parts.PerturbationParams()),
    )
    for operator in parts.OPERATORS:
        if operator.supports(data):
            local.add_operator(operator(data))
    mean = max(float(instance.stop_weights.mean()), 1.0)
    matrix = data.distance_matrix(0)
    largest = max(float(instance.stop_distances.max()), 1e-300)
    price = OVERLOAD * float(matrix.max()) * min(usual_distance(instance) / largest, 1.0) / mean
    price = max(1.0, price) * max(vehicle.unit_distance_cost for vehicle in data.vehicle_types())
    highest = max(price, MOST_OVERLOAD * float(matrix.max()) / mean)
    limits = pyvrp.PenaltyParams() if plain else pyvrp.PenaltyParams(max_penalty=highest)
    first_prices = limits.midpoint_penalties(data) if plain else ([price], price, price)
    prices = pyvrp.PenaltyManager(first_prices, limits)
    if first is None or len(instance.stops) > MANY:
        begin = pyvrp.Solution.make_random(data, rng) if first is None else first
        first = local(begin, prices.max_cost_evaluator(), exhaustive=True)
    return IteratedLocalSearch(
        data, prices, local, first, IteratedLocalSearchParams(callbacks=callbacks)
    )


def _routes(instance: Instance, solution: pyvrp.Solution) -> Routes:
    return [
        [
            node
            for activity in route
            if activity.is_client()
            for node in instance.stops[activity.idx]
        ]
        for route in solution.routes()
    ]


def _solution(instance: Instance, data: pyvrp.ProblemData, routes: Routes) -> pyvrp.Solution:
    """Turn feasible routes into PyVRP's form: the heaviest onto the largest vehicles."""
    import pyvrp

    stop_of = {node: s for s, nodes in enumerate(instance.stops) for node in nodes}
    kinds = [
        kind
        for kind, vehicle in sorted(
            enumerate(data.vehicle_types()), key=lambda v: -v[1].capacity[0]
        )
        for _ in range(vehicle.num_available)
    ]
    heaviest_first = sorted(
        (route for route in routes if route),
        key=lambda route: -sum(int(instance.weights[v - 1]) for v in route),
    )
    return pyvrp.Solution(
        data,
        [
            pyvrp.Route(data, list(dict.fromkeys(stop_of[v] for v in route)), kind)
            for route, kind in zip(heaviest_first, kinds, strict=False)
        ],
    )
