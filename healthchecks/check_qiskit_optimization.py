# %% [markdown]
# # Qiskit Optimization: a constraint becomes a penalty
#
# Quantum samplers know no constraints, only energies. This package turns a program with
# constraints into a QUBO (quadratic unconstrained binary optimisation) and translates the answer
# back. qRobot builds its own QUBOs and holds them against this one.

# %%
from qiskit_optimization import QuadraticProgram
from qiskit_optimization.converters import QuadraticProgramToQubo

from qrobot.health.checks.qiskit_optimization import CHECK, ROOM, WEIGHT, WORTH
from qrobot.health.lesson import table, verdict

program = QuadraticProgram("knapsack")
for k in range(len(WORTH)):
    program.binary_var(f"x{k}")
program.maximize(linear={f"x{k}": value for k, value in enumerate(WORTH)})
program.linear_constraint({f"x{k}": w for k, w in enumerate(WEIGHT)}, "<=", ROOM, "room")
print(program.prettyprint())

# %% [markdown]
# ## Slack
#
# "At most 4" is an inequality. A slack $s = 4 - \sum w_i x_i$ makes it an equation, and bits make
# the slack; then $P\,(\sum w_i x_i + s - 4)^2$ is zero exactly for what fits. The penalty $P$ must
# be larger than anything that breaking the rule could earn.

# %%
converter = QuadraticProgramToQubo()
qubo = converter.convert(program)
print("variables:", [v.name for v in qubo.variables], " penalty:", converter.penalty)

# %%
rows = []
for number in range(2 ** len(WORTH)):
    bits = [number >> k & 1 for k in range(len(WORTH))]
    weight = sum(w * b for w, b in zip(WEIGHT, bits, strict=True))
    slacks = range(2 ** (qubo.get_num_vars() - len(WORTH)))
    low = min(
        qubo.objective.evaluate([*bits, *(s >> k & 1 for k in range(qubo.get_num_vars() - 3))])
        for s in slacks
    )
    rows.append((str(bits), weight, "yes" if weight <= ROOM else "no", float(low)))
table(["packing", "weight", "fits", "lowest energy of the QUBO"], rows)

# %% [markdown]
# What fits has minus its worth as energy; what does not is pushed up.
#
# ## The check
#
# The ground state of the QUBO's Hamiltonian is found by its matrix and translated back. All eight
# packings in plain Python say what it must be.

# %%
verdict(CHECK, ["worth told", "worth of the packing", "weight too much"])

# %% [markdown]
# ## Try it yourself
#
# 1. Give `QuadraticProgramToQubo(penalty=1)`. Which packing wins now, and does it fit?
# 2. How many slack bits does room for 1,000 need? Why does qRobot divide by the common unit first?
