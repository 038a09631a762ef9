"""Answers found without any code of the package: what solvers are held against.

>>> from oracles import least_distance
"""

from __future__ import annotations

import math
import random
from fractions import Fraction
from functools import cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

__all__ = ["assignments", "least_distance", "paper_shaped", "subset_programme"]


def assignments(variables: int) -> npt.NDArray[np.int8]:
    """Return every assignment of up to 32 binary variables, a row each, counted upwards."""
    numbers = np.arange(2**variables, dtype=">u4")
    bits = np.unpackbits(numbers.view(np.uint8).reshape(-1, 4), axis=1)
    return bits[:, 32 - variables :].view(np.int8)


def least_distance(instance: Instance) -> tuple[float, int] | None:
    """Return the least distance of any plan and the fewest trips at it, or None.

    A dynamic programme over sets of orders in plain Python: robots one after the other,
    each takes any set that it can carry, whose tour is found by trying sequences with
    memory. Weights stay fractions; nothing of `Instance` but its input is used, except
    the distance matrix, which the tests of the problem room hold against networkx.
    """
    d = instance.distances.tolist()
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    weight = {item.id: item.weight for item in instance.items}
    lots = [tuple(node[i] for i in order.items) for order in instance.orders]
    loads = [sum((weight[i] for i in order.items), Fraction(0)) for order in instance.orders]

    @cache
    def path(last: int, left: frozenset[int]) -> float:
        if not left:
            return float(d[last][0])
        return min(d[last][v] + path(v, left - {v}) for v in left)

    def tour(orders: frozenset[int]) -> float:
        return path(0, frozenset(v for o in orders for v in lots[o]))

    seats = [robot.capacity for robot in instance.robots for _ in range(robot.trips)]
    seats = sorted(seats, reverse=True)[: max(len(lots), 1)]
    everything = frozenset(range(len(lots)))
    tours: dict[frozenset[int], float] = {}

    @cache
    def best(seat: int, left: frozenset[int]) -> tuple[float, int]:
        if not left:
            return 0.0, 0
        if seat == len(seats):
            return math.inf, 0
        found = best(seat + 1, left)  # the robot stays home
        members = sorted(left)
        for size in range(1, len(members) + 1):
            for chosen in combinations(members, size):
                if sum((loads[o] for o in chosen), Fraction(0)) > seats[seat]:
                    continue
                batch = frozenset(chosen)
                if batch not in tours:
                    tours[batch] = tour(batch)
                rest, trips = best(seat + 1, left - batch)
                total = round(tours[batch] + rest, 9)
                found = min(found, (total, trips + 1))
        return found

    distance, trips = best(0, everything)
    return None if math.isinf(distance) else (distance, trips)


def paper_shaped(items: int, robots: int, seed: int) -> Instance:
    """Return a random instance in the shape of the paper's: a floor, whole kilograms.

    Capacity is tight: max(heaviest item, ceil(1.1 W / K)).
    """
    rng = random.Random(f"{items}/{robots}/{seed}")
    weights = [rng.randint(1, 10) for _ in range(items)]
    capacity = max(*weights, math.ceil(Fraction(11 * sum(weights), 10 * robots)))
    return Instance(
        warehouse=OpenFloor(depot_x=50.0, depot_y=50.0),
        items=tuple(
            Item(f"i{n + 1}", Fraction(w), Point(rng.uniform(0, 100), rng.uniform(0, 100)))
            for n, w in enumerate(weights)
        ),
        orders=tuple(Order(f"i{n + 1}", (f"i{n + 1}",)) for n in range(items)),
        robots=tuple(Robot(f"R{k + 1}", Fraction(capacity)) for k in range(robots)),
        name=f"paper-shaped-{items}-{robots}-{seed}",
    )


def subset_programme(instance: Instance) -> float | None:
    """Return the least distance by a subset dynamic programme, for up to 12 single items.

    Faster than `least_distance` (bit masks instead of sets), for instances in which every
    item is its own order and robots are alike. None when no plan exists.
    """
    d = instance.distances.tolist()
    n = len(instance.items)
    weight = [item.weight for item in instance.items]
    room = instance.robots[0].capacity
    load = [Fraction(0)] * (1 << n)
    for mask in range(1, 1 << n):
        low = mask & -mask
        load[mask] = load[mask ^ low] + weight[low.bit_length() - 1]
    path = [[math.inf] * n for _ in range(1 << n)]
    tour = [math.inf] * (1 << n)
    tour[0] = 0.0
    for mask in range(1, 1 << n):
        if load[mask] > room:
            continue
        for j in range(n):
            rest = mask ^ (1 << j)
            if not mask >> j & 1:
                continue
            if not rest:
                path[mask][j] = d[0][j + 1]
            else:
                before = path[rest]
                path[mask][j] = min(before[i] + d[i + 1][j + 1] for i in range(n) if rest >> i & 1)
        tour[mask] = min(path[mask][j] + d[j + 1][0] for j in range(n) if mask >> j & 1)
    best = tour
    for _ in range(len(instance.robots) - 1):
        better = [math.inf] * (1 << n)
        better[0] = 0.0
        for mask in range(1, 1 << n):
            low = mask & -mask
            others = mask ^ low
            part, least = others, best[mask]
            while True:
                here = tour[part | low]
                if here < least:
                    least = min(least, here + best[others ^ part])
                if not part:
                    break
                part = (part - 1) & others
            better[mask] = least
        best = better
    return None if math.isinf(best[-1]) else best[-1]
