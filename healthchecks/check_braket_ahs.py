# %% [markdown]
# # Braket AHS: atoms instead of gates
#
# QuEra's Aquila is an analog machine: up to 256 rubidium atoms held by light, driven by one laser
# pulse. There are no gates; the atoms follow their Hamiltonian, and one places them so that it is
# the question. `braket_ahs` simulates this by integrating Schrödinger's equation.
#
# An atom is in its ground state $|g\rangle$ or, driven, in a huge Rydberg state $|r\rangle$. Two
# near atoms cannot both be in $|r\rangle$: the shift $C_6/d^6$ puts the pair out of the laser's
# reach. That is the blockade. "No two neighbours" is what an independent set asks for.

# %%
import math

import numpy as np
from braket.devices import LocalSimulator

from qrobot.health.checks.braket_ahs import APART, CHECK, EDGE, PEAK, RAMP, SCATTER, pair, program
from qrobot.health.lesson import draw, table, verdict

print(f"a pulse of {PEAK:g} rad/s, rising in {RAMP:g} s; atoms {APART * 1e6:g} micrometres apart")
pulse = program(1, math.pi).hamiltonian.amplitude.time_series
times, values = [float(t) * 1e6 for t in pulse.times()], [float(v) for v in pulse.values()]
draw(lambda axes: axes.fill_between(times, values, alpha=0.4))

# %% [markdown]
# ## One atom turns, two turn faster
#
# A resonant pulse of area $A = \int \Omega\,dt$ leaves one atom in $|r\rangle$ with the probability
# $\sin^2(A/2)$: with $A = \pi$ surely. Two blockaded atoms share one excitation,
# $(|gr\rangle + |rg\rangle)/\sqrt2$, and behave as a single atom with $\sqrt2\,\Omega$.

# %%
np.random.seed(2)  # noqa: NPY002 - the simulator draws from numpy's global generator
device, rows = LocalSimulator("braket_ahs"), []
for area in (0.25 * math.pi, 0.5 * math.pi, math.pi / math.sqrt(2), math.pi):
    row = [area / math.pi]
    for atoms in (1, 2):
        shots = device.run(program(atoms, area), shots=100, steps=100).result().measurements
        row.append(float(np.mean([np.sum(shot.post_sequence == 0) > 0 for shot in shots])))
    rows.append((*row, math.sin(area / 2) ** 2, math.sin(area / math.sqrt(2)) ** 2))
table(["area / pi", "one atom", "a pair", "theory, one", "theory, pair"], rows)

# %% [markdown]
# ## The edge of the blockade
#
# Farther apart the shift fades, with the sixth power. Where it is about as strong as the laser,
# neither picture holds, and only Schrödinger's equation tells: four states, four by four matrices.

# %%
table(
    ["micrometres apart", "none up", "one up", "both up"],
    [(apart * 1e6, *map(float, pair(2 * math.pi, apart))) for apart in (APART, 7e-6, EDGE, 15e-6)],
)

# %% [markdown]
# ## The check
#
# Three pulses that must end the same way in every shot: one atom flopped by $\pi$; of two atoms
# exactly one up after $\pi/\sqrt2$; of two atoms none up after $2\pi/\sqrt2$. All of them would
# come out right with a $C_6$ that is ten times too small. So two atoms at the edge, 9 micrometres
# apart, get $2\pi$: there a tenth more moves the part with one up by 0.085. These parts scatter as
# the 2,000 shots do, so they count with three tenths of their weight.

# %%
print("weight of the parts at the edge:", SCATTER)
verdict(
    CHECK,
    ["one atom up", "one of two up", "both down again", "edge: none", "edge: one", "edge: both"],
)

# %% [markdown]
# ## Try it yourself
#
# 1. Let the simulator move the atoms 15 micrometres apart: `program(2, area, 15e-6)`. What does the
#    pair do now, and is it what `pair` says?
# 2. Three atoms in a row: which are up after a slow pulse, and which set of nodes is that?
