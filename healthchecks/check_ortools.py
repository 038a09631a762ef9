# %% [markdown]
# # OR-Tools: choosing trips, and proving the choice
#
# When all trips that one robot could make are known, planning becomes a choice: take trips so that
# every order is in exactly one, at the least total length. This *set partition* is what qRobot asks
# CP-SAT, Google's solver, for middle-sized questions. It searches, learns clauses from what went
# wrong, and bounds from below by linear programming.

# %%
import itertools

from ortools.sat.python import cp_model

from qrobot.health.checks.ortools import CHECK, ORDERS, TRIPS
from qrobot.health.lesson import table, verdict

table(
    ["trip", *(f"order {o}" for o in range(ORDERS)), "length"],
    [
        (k, *("x" if o in orders else "" for o in range(ORDERS)), length)
        for k, (orders, length) in enumerate(TRIPS)
    ],
)

# %%
model = cp_model.CpModel()
taken = [model.new_bool_var(f"trip {k}") for k in range(len(TRIPS))]
for order in range(ORDERS):
    model.add_exactly_one(taken[k] for k, (orders, _) in enumerate(TRIPS) if order in orders)
model.minimize(sum(length * taken[k] for k, (_, length) in enumerate(TRIPS)))
solver = cp_model.CpSolver()
solver.parameters.num_workers = 1
status = solver.solve(model)
chosen = [k for k in range(len(TRIPS)) if solver.value(taken[k])]
print(solver.status_name(status), "trips", chosen, "length", solver.objective_value)

# %% [markdown]
# ## What a proof is worth
#
# The solver gives two numbers: the best choice found, and a bound that no choice can beat. When
# they meet, the answer is proven. Here all $2^9$ choices can be looked at; with a million trips
# nobody can, and the two numbers are all one has.

# %%
partitions = [
    choice
    for size in range(1, ORDERS + 1)
    for choice in itertools.combinations(range(len(TRIPS)), size)
    if sorted(o for k in choice for o in TRIPS[k][0]) == list(range(ORDERS))
]
table(["trips", "length"], [(str(p), sum(TRIPS[k][1] for k in p)) for p in partitions])
print("found", solver.objective_value, " bound", solver.best_objective_bound)

# %% [markdown]
# ## The check
#
# What was found, its bound, the length of the chosen trips added up anew, and how many orders are
# served, against all choices in plain Python.

# %%
verdict(CHECK, ["length found", "bound", "length added up", "orders served"])

# %% [markdown]
# ## Try it yourself
#
# 1. Let orders be served twice (`add_bool_or` for `add_exactly_one`). Can it become shorter?
# 2. As a QUBO each order becomes $P(\sum_k a_{ok} x_k - 1)^2$. How large must $P$ be?
