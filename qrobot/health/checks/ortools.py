"""OR-Tools: CP-SAT covers orders with trips at the least length, and proves it."""

import itertools

from qrobot.health.check import Check

TRIPS = (
    ({0, 1}, 9), ({2, 3}, 8), ({0, 2}, 7), ({1, 3}, 12), ({4}, 5), ({0}, 6), ({1, 4}, 8),
    ({3}, 4), ({2, 3, 4}, 11),
)  # fmt: skip
ORDERS = 5


def answer() -> list[float]:
    """Return the length found, its bound, and the lengths of the trips that were chosen."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    taken = [model.new_bool_var(f"trip {k}") for k in range(len(TRIPS))]
    for order in range(ORDERS):
        model.add_exactly_one(taken[k] for k, (orders, _) in enumerate(TRIPS) if order in orders)
    model.minimize(sum(length * taken[k] for k, (_, length) in enumerate(TRIPS)))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.solve(model)
    chosen = [trip for k, trip in enumerate(TRIPS) if solver.value(taken[k])]
    return [
        solver.objective_value,
        solver.best_objective_bound,
        sum(length for _, length in chosen),
        sum(len(orders) for orders, _ in chosen),
    ]


def expected() -> list[float]:
    """Return the least of all choices of trips, thrice, and every order once."""
    best = min(
        sum(length for _, length in chosen)
        for size in range(1, ORDERS + 1)
        for chosen in itertools.combinations(TRIPS, size)
        if sorted(order for orders, _ in chosen for order in orders) == list(range(ORDERS))
    )
    return [best, best, best, ORDERS]


CHECK = Check(
    __name__,
    title="a set partition by CP-SAT",
    group="solver",
    imports=("ortools.sat.python.cp_model",),
    distributions=("ortools",),
    source="all choices of trips, in plain Python",
    tolerance=1e-6,
    extra="planners",
)
