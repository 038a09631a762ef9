# %% [markdown]
# # dwave-hybrid: take apart, improve, put back
#
# A model with thousands of variables fits on no QPU. A hybrid workflow takes out the variables that
# promise most, gives this small part to a sampler (a QPU, or tabu), puts the answer back, and
# starts again. dwave-hybrid is a kit for such workflows: `|` joins steps, `Race` lets branches
# compete.

# %%
import dimod
import hybrid

from qrobot.health import known
from qrobot.health.checks.dwave_hybrid import CHECK
from qrobot.health.lesson import table, verdict

model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
start = hybrid.State.from_sample(dict.fromkeys(model.variables, 1), model)
print("start, all spins up:", start.samples.first.energy, "  ground state:", known.lowest())

# %% [markdown]
# ## Taking out
#
# The decomposer ranks variables by what flipping them would gain. The part that it takes out is a
# model of its own: the couplings to the rest, which is held still, become fields.

# %%
part = hybrid.EnergyImpactDecomposer(size=4).run(start).result().subproblem
table(
    ["variable", "field before", "field in the part"],
    [(v, model.linear[v], float(part.linear[v])) for v in part.variables],
)

# %% [markdown]
# ## Improving, and putting back
#
# With the rest held still the best of a part is never worse than before. But it may be no better:

# %%
rows = []
for size in range(2, 7):
    turn = (
        hybrid.EnergyImpactDecomposer(size=size)
        | hybrid.TabuSubproblemSampler(num_reads=2, timeout=20)
        | hybrid.SplatComposer()
    )
    after = turn.run(start).result().samples.first
    flipped = [v for v in model.variables if after.sample[v] < 0]
    rows.append((size, str(flipped), float(after.energy)))
table(["size of the part", "flipped", "energy after one turn"], rows)

# %% [markdown]
# This start is a trap for small parts: flipping a few promising spins gains nothing, five together
# do. Hence large parts, other parts in every turn, and a competing branch.
#
# ## The check
#
# A whole workflow: parts of six variables by tabu, beside tabu on everything, the better one kept,
# three times. Its best energy, as reported and computed again, against all 256 states. Tabu on
# everything solves this small model alone and would hide parts that do nothing, so the parts must
# reach the ground state without it too, in twenty turns.

# %%
verdict(CHECK, ["energy told", "energy of the state", "energy by parts alone"])

# %% [markdown]
# ## Try it yourself
#
# 1. Put `turn` into `hybrid.Loop(turn, max_iter=10)`. Which sizes reach the ground state, and what
#    does `rolling_history=1.0` in the decomposer change?
# 2. What would have to change to give the parts to a real QPU? (One name.)
