"""docplex: a model's objective and constraints for every packing (solving needs CPLEX)."""

import itertools

from qrobot.health import known
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
            worth.append(solution.get_value(model.objective_expr) if fits else -1.0)
    return worth


def expected() -> list[float]:
    """Return the same by arithmetic."""
    worth: list[float] = []
    for bits in itertools.product((0, 1), repeat=len(WORTH)):
        value = known.sum_of_chosen(WORTH, bits) + 2 * bits[0] * bits[1]
        worth.append(value if known.sum_of_chosen(WEIGHT, bits) <= ROOM else -1.0)
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
