# %% [markdown]
# # docplex: writing a program as mathematics
#
# docplex is IBM's modelling language in Python. Solving needs CPLEX, which has no build for a Pi;
# but Qiskit Optimization reads its models, so it is a door from operations research to a QUBO.
# qRobot can write its question as a docplex model.

# %%
from docplex.mp.model import Model

from qrobot.health.checks.docplex import CHECK, ROOM, WEIGHT, WORTH
from qrobot.health.lesson import table, verdict

model = Model(name="knapsack")
x = model.binary_var_list(len(WORTH), name="x")
model.add_constraint(model.scal_prod(x, WEIGHT) <= ROOM, "room")
model.maximize(model.scal_prod(x, WORTH) + 2 * x[0] * x[1])
print(model.export_as_lp_string())

# %% [markdown]
# This is the LP format: what a solver, or a colleague without Python, would be sent. The product
# $2 x_0 x_1$ says that items 0 and 1 are worth more together. It makes the program quadratic,
# which for a quantum sampler costs nothing: couplings are what it has.
#
# ## Asking a model without solving it
#
# A solution can also be proposed, and docplex says what it is worth and whether it is allowed:

# %%
proposals = [(1, 1, 0, 1), (1, 1, 1, 0), (0, 0, 1, 1), (1, 0, 1, 0)]
rows = []
for bits in proposals:
    proposal = model.new_solution(dict(zip(x, bits, strict=True)), keep_zeros=True)
    allowed = proposal.is_feasible_solution(silent=True)
    worth = proposal.get_value(model.objective_expr)
    rows.append((str(bits), float(worth), "yes" if allowed else "no"))
table(["packing", "worth", "fits"], rows)
model.end()

# %% [markdown]
# ## The check
#
# All 16 packings, by docplex and by arithmetic; -1 stands for one that does not fit.

# %%
verdict(CHECK, [f"packing {k:04b}" for k in range(16)])

# %% [markdown]
# ## Try it yourself
#
# 1. With `qiskit_optimization.translators.from_docplex_mp(model)` take the model to Qiskit, before
#    `model.end()`, and solve it as in `check_qiskit_optimization`.
# 2. Forbid items 2 and 3 together with one more constraint. Which packing is best now?
