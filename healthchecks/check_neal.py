# %% [markdown]
# # neal: simulated annealing
#
# A hot metal that cools slowly finds an arrangement of low energy. neal simulates this in C++: it
# flips one spin after the other and accepts a flip that costs $\Delta E$ with the probability
# $\min(1, e^{-\beta \Delta E})$, while $\beta$ (one over the temperature) rises. It needs no
# quantum hardware, takes the same models, and is qRobot's sampler of first choice on a robot.

# %%
import dimod
import neal

from qrobot.health import known
from qrobot.health.checks.neal import CHECK
from qrobot.health.lesson import draw, table, verdict

model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
annealer = neal.SimulatedAnnealingSampler()

# %% [markdown]
# ## More sweeps, better reads
#
# A sweep offers every spin one flip. With more sweeps the cooling is slower, and more of the 500
# reads end in the ground state. Eight spins are easy; the pattern is the same for hard models.

# %%
rows = []
for sweeps in (1, 2, 4, 8, 16, 64):
    found = annealer.sample(model, num_reads=500, num_sweeps=sweeps, seed=1)
    hits = int((found.record.energy <= known.lowest() + 1e-9).sum())
    rows.append((sweeps, hits / 500, float(found.record.energy.mean())))
table(["sweeps", "ground state in", "mean energy"], rows)
draw(lambda axes: axes.semilogx([r[0] for r in rows], [r[1] for r in rows], marker="o"))

# %% [markdown]
# ## The check
#
# A sampler may be unlucky, so the check takes 100 reads of a model whose ground state is known by
# trying all 256 states. Two numbers: the energy that neal reports, and the energy of the state that
# it returned, computed again. A sampler that finds the state and reports a wrong energy is wrong.

# %%
verdict(CHECK, ["energy told", "energy of the state"])

# %% [markdown]
# ## Try it yourself
#
# 1. `beta_range=(5, 5)` keeps it cold from the start. What happens to the share of ground states?
# 2. Multiply the whole model by 1000. Why does the answer stay as good without changing $\beta$?
