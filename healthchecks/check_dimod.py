# %% [markdown]
# # dimod: the language that annealers speak
#
# A binary quadratic model is an energy of many yes-or-no questions,
#
# $$E(s) = \sum_i h_i s_i + \sum_{i<j} J_{ij} s_i s_j + c, \qquad s_i = \pm 1 .$$
#
# dimod holds such models, changes between spins $s = \pm 1$ and bits $x = (1+s)/2$, and defines
# what a sampler is. In qRobot every order list becomes one of these, and every annealer, real or
# simulated, takes it from there.

# %%
import dimod
import numpy as np

from qrobot.health import known
from qrobot.health.checks.dimod import CHECK
from qrobot.health.lesson import draw, verdict

whole = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
print(whole.num_variables, "spins,", whole.num_interactions, "couplings")

# %% [markdown]
# ## The landscape
#
# Eight spins have $2^8 = 256$ states: few enough to look at every energy. An annealer is asked
# for the leftmost bar.

# %%
states = known.all_spins(len(known.FIELDS))
energies = whole.energies((states, range(len(known.FIELDS))))
draw(lambda axes: axes.hist(energies, bins=np.arange(energies.min(), energies.max() + 2)))
print("lowest", energies.min(), "by", int((energies == energies.min()).sum()), "state(s)")

# %% [markdown]
# ## The same energy in bits
#
# With $s = 2x - 1$ a coupling becomes $J s_i s_j = J(4 x_i x_j - 2 x_i - 2 x_j + 1)$: four times
# as strong, and the rest moves into the linear terms and the offset. The numbers look different,
# the energies are not:

# %%
bits = whole.change_vartype("BINARY", inplace=False)
print("spins: h0 =", whole.linear[0], " J01 =", whole.quadratic[0, 1], " offset =", whole.offset)
print("bits:  h0 =", bits.linear[0], " J01 =", bits.quadratic[0, 1], " offset =", bits.offset)

# %% [markdown]
# ## The check
#
# All 16 states of the first four spins, once as spins and once as bits, and the ground state of
# all eight by dimod's exhaustive solver. The expected numbers come from the formula above in plain
# numpy, which knows nothing of dimod.

# %%
states16 = [f"state {k:04b}, as {kind}" for kind in ("spins", "bits") for k in range(16)]
verdict(CHECK, [*states16, "lowest of 256"])

# %% [markdown]
# ## Try it yourself
#
# 1. Add a penalty $3\,(x_0 + x_1 - 1)^2$ to the model in bits. Which states does it punish?
# 2. Set all fields to zero. Why does every energy now come an even number of times?
