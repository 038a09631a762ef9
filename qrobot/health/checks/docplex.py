"""docplex: a model's objective and constraints for every packing (solving needs CPLEX)."""

import itertools

from qrobot.health.check import Check

WORTH, WEIGHT, ROOM = (4, 3, 6, 5), (2, 1, 3, 2), 5


def answer() -> list[float]:
    """Return worth, or -1 where docplex says that it does not fit, of all packings."""
    from docplex.mp.model import Model

    with Model(name="knapsack") as model:
        x = model.binary_var_list(len(WORTH), name="x")
        model.add_constraint(model.scal_prod(x, WEIGHT) <= ROOM)
        pairs = 2 * x[0] * x[1]
        model.maximize(model.scal_prod(x, WORTH) + pairs)
        worth = []
        for bits in itertools.product((0, 1), repeat=len(WORTH)):
            solution = model.new_solution(dict(zip(x, bits, strict=True)), keep_zeros=True)
            fits = solution.is_feasible_solution(silent=True)
            value = solution.get_value(model.objective_expr)
            worth.append(float(value) if fits else -1.0)
    return worth


def expected() -> list[float]:
    """Return the same by arithmetic."""
    worth = []
    for bits in itertools.product((0, 1), repeat=len(WORTH)):
        weight = sum(w * bit for w, bit in zip(WEIGHT, bits, strict=True))
        value = sum(v * bit for v, bit in zip(WORTH, bits, strict=True)) + 2 * bits[0] * bits[1]
        worth.append(float(value) if weight <= ROOM else -1.0)
    return worth


CHECK = Check(
    __name__,
    title="a quadratic model, every packing",
    group="modelling",
    imports=("docplex.mp.model",),
    distributions=("docplex",),
    source="arithmetic in plain Python",
    extra="docplex",
)
