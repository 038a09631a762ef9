"""The paper's table 2 (M = 15, one robot) with places of ours, for the gate samplers."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import permutations

from qrobot.models import build_model
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot


def table2(items: int, seed: int = 0) -> Instance:
    """Return an instance of table 2: `items` items of 2 to 5 kg, one robot of 15 kg."""
    rng = random.Random(f"table2/{items}/{seed}")
    weights = [3, 4, *(rng.randint(2, 5) for _ in range(items - 2))]  # no common unit: 4 slack bits
    made = tuple(
        Item(f"i{n + 1}", Fraction(weights[n]), Point(rng.uniform(0, 20), rng.uniform(0, 20)))
        for n in range(items)
    )
    return Instance(
        warehouse=OpenFloor(depot_x=10.0, depot_y=10.0),
        items=made,
        orders=tuple(Order(item.id, (item.id,)) for item in made),
        robots=(Robot("R1", Fraction(15)),),
        name=f"table2-{items}-{seed}",
    )


def table2_model(items: int, seed: int = 0):
    """Return the penalty form of `table2` in the paper's qubit count; its ground is a plan."""
    instance = table2(items, seed)
    step = 2 * float(instance.distances.max())
    weights = {"step": step, "visit": step, "capacity": step / 20}
    return build_model(instance, encoding="reduced", slack="paper", penalties=weights)


def shortest(instance: Instance) -> float:
    """Return the least distance by trying every sequence."""
    d = instance.distances
    return min(
        float(sum(d[a, b] for a, b in zip((0, *tour), (*tour, 0), strict=True)))
        for tour in permutations(range(1, len(instance.items) + 1))
    )
