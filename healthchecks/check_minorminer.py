# %% [markdown]
# # minorminer: a large graph folded into a poor one
#
# A D-Wave machine couples each qubit with a few others only. A model that wants more couplings is
# embedded: one variable becomes a chain of qubits that hold together. minorminer looks for such
# chains by a heuristic in C++ (Cai, Macready and Roy 2014, arXiv 1406.2741). Before any order list
# reaches the QPU, it has gone through here.

# %%
import itertools

import minorminer

from qrobot.health.checks.minorminer import CHECK, SIDE, lattice
from qrobot.health.lesson import draw, table, verdict

five = list(itertools.combinations(range(5), 2))
edges = lattice()
chains = minorminer.find_embedding(five, sorted(edges), random_seed=3, tries=50)
table(["variable", "its chain of qubits"], [(k, str(chain)) for k, chain in chains.items()])

# %% [markdown]
# The complete graph of five variables has $5 \cdot 4 / 2 = 10$ couplings. Our toy machine is a
# lattice of 16 qubits with both diagonals. It crosses itself, otherwise five would be impossible:
# $K_5$ is not a minor of any planar graph (Wagner 1937).

# %%


def picture(axes):
    """Draw the lattice, and every chain in a colour of its own."""
    for a, b in edges:
        axes.plot([a % SIDE, b % SIDE], [a // SIDE, b // SIDE], color="0.85", zorder=0)
    for variable, chain in chains.items():
        spots = [(node % SIDE, node // SIDE) for node in chain]
        axes.scatter(*zip(*spots, strict=True), s=220, color=f"C{variable}")
        for x, y in spots:
            axes.text(x, y, variable, ha="center", va="center", color="white")
    axes.set_axis_off()


draw(picture, size=(3, 3))

# %% [markdown]
# ## The check
#
# A heuristic may give another embedding every time, so the check verifies what any embedding must
# be: every variable has a chain, each chain hangs together, no qubit is in two chains, and each of
# the ten couplings meets an edge. The verification is graph search in plain Python.

# %%
verdict(CHECK, ["chains", "hang together", "qubits used twice", "couplings met"])

# %% [markdown]
# ## Try it yourself
#
# 1. Embed six, seven, eight variables. When does it give up, and is that a proof?
# 2. Take the diagonals out of the lattice and try four variables, then five.
