"""dwave-optimization: a nonlinear model of a round trip, its length for every sequence."""

import itertools

import numpy as np

from qrobot.health.check import Check

WAYS = ((0, 7, 3, 9, 4), (7, 0, 5, 2, 8), (3, 5, 0, 6, 1), (9, 2, 6, 0, 7), (4, 8, 1, 7, 0))
STOPS, LIMIT = len(WAYS), 20


def answer() -> list[float]:
    """Return the round trip's length, and whether it keeps the limit, of all sequences."""
    from dwave.optimization import Model

    model = Model()
    ways = model.constant(np.array(WAYS, dtype=float))
    sequence = model.list(STOPS)
    length = ways[sequence[:-1], sequence[1:]].sum() + ways[sequence[-1], sequence[0]]
    model.minimize(length)
    short = model.add_constraint(length <= model.constant(LIMIT))
    orders = list(itertools.permutations(range(STOPS)))
    numbers: list[float] = []
    with model.lock():
        model.states.resize(len(orders))
        for k, order in enumerate(orders):
            sequence.set_state(k, order)
            numbers += [model.objective.state(k), short.state(k)]
    return numbers


def expected() -> list[float]:
    """Return the same by arithmetic."""
    numbers: list[float] = []
    for order in itertools.permutations(range(STOPS)):
        length = sum(WAYS[a][b] for a, b in itertools.pairwise((*order, order[0])))
        numbers += [length, length <= LIMIT]
    return numbers


CHECK = Check(
    __name__,
    title="a nonlinear model, every sequence",
    group="annealing",
    imports=("dwave.optimization",),
    distributions=("dwave-optimization",),
    source="arithmetic in plain Python",
    extra="dwave",
)
