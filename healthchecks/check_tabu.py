# %% [markdown]
# # tabu: downhill, with a memory
#
# Tabu search flips the spin that lowers the energy most. In a valley, where every flip is uphill,
# it takes the least bad one and forbids (tabu) to flip it back for a while: so it climbs out
# instead of falling back. It has no temperature to tune; `qrobot solve --backend tabu` uses it.

# %%
import dimod
from dwave.samplers import TabuSampler

from qrobot.health import known
from qrobot.health.checks.tabu import CHECK
from qrobot.health.lesson import table, verdict

# %% [markdown]
# ## Why plain descent is not enough
#
# A state is a local minimum when all eight neighbours (one spin flipped) are higher or equal.
# Descent stops in the first that it meets. From how many of the 256 states does it reach the best?

# %%
count = len(known.FIELDS)
energy = known.energies(known.all_spins(count))


def descend(state):
    """Flip the best bit until no flip helps; a state is a number, its bits are the spins."""
    while True:
        best = min((state ^ (1 << k) for k in range(count)), key=lambda other: energy[other])
        if energy[best] >= energy[state]:
            return state
        state = best


ends = [descend(state) for state in range(2**count)]
table(
    ["valley", "energy", "states that fall into it"],
    [(f"{end:08b}", float(energy[end]), ends.count(end)) for end in sorted(set(ends))],
)

# %% [markdown]
# ## The same with a memory
#
# Ten searches, each begun somewhere else:

# %%
model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
found = TabuSampler().sample(model, num_reads=10, num_restarts=20, timeout=5000, seed=1)
print("energies:", sorted(found.record.energy.tolist()), "lowest of all:", known.lowest())

# %% [markdown]
# ## The check
#
# The lowest energy that was reported, and the energy of its state computed again, against the least
# of all 256 states in plain numpy.

# %%
verdict(CHECK, ["energy told", "energy of the state"])

# %% [markdown]
# ## Try it yourself
#
# 1. Let `descend` choose any flip that helps instead of the best one. Are more states saved?
# 2. `tenure=1` makes the memory short. Can you find a model where the search then goes in circles?
