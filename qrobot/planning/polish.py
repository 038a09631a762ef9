"""From what a sampler gave to a valid, short plan: repair and polish.

Repair keeps every order that a read collected whole and within a robot's capacity, and
inserts the rest where it costs least. Polish is ruin and recreate for a fixed number of
rounds. The same code runs on random starts, which is the control that every result of a
sampler is shown beside.
"""

from __future__ import annotations

import math

import numpy as np

from qrobot.backends import Routes, Stop
from qrobot.backends.classical.batching import SearchData, batches_of, ruin_and_recreate
from qrobot.problem import Instance

__all__ = ["POLISH_ROUNDS", "random_routes", "repair_and_polish"]

POLISH_ROUNDS = 30
"""Rounds of ruin and recreate for each start."""


def repair_and_polish(
    instance: Instance, start: Routes, stop: Stop, seed: int, rounds: int = POLISH_ROUNDS
) -> Routes | None:
    """Return a valid plan made from any routes, or None when no room or way was found.

    Parameters
    ----------
    instance
        The question.
    start
        Routes of nodes; may leave out, repeat, split or overload.
    stop
        Deadline and interrupts.
    seed
        Of the random choices.
    rounds
        Rounds of polish; 0 repairs only.
    """
    data = SearchData(instance, seed, stop)
    state = batches_of(data, start)
    routes = ruin_and_recreate(data, state, stop.within(max_work=rounds))
    return None if routes is None or math.isinf(instance.length(routes)) else routes


def random_routes(instance: Instance, rng: np.random.Generator) -> Routes:
    """Return orders dealt to trips at random, in random sequence; loads are not looked at."""
    trips: Routes = [[] for _ in instance.vehicle_capacities]
    for order in rng.permutation(len(instance.orders)).tolist():
        nodes = list(instance.order_nodes[order])
        rng.shuffle(nodes)
        trips[int(rng.integers(len(trips)))].extend(nodes)
    return trips
