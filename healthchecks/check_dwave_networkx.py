# %% [markdown]
# # dwave-networkx: the maps of the machines
#
# Which qubits can talk to which? D-Wave has built three generations: Chimera (six couplings a
# qubit), Pegasus (fifteen, the Advantage) and Zephyr (twenty, the Advantage2). This package draws
# their graphs, and the mock QPU and the embedding tools of the robot use them.

# %%
import dwave_networkx as dnx

from qrobot.health.checks.dwave_networkx import CELLS, CHECK, SHORE
from qrobot.health.lesson import draw, table, verdict

machines = {
    "Chimera C4": dnx.chimera_graph(CELLS, CELLS, SHORE),
    "Pegasus P4": dnx.pegasus_graph(4),
    "Zephyr Z3": dnx.zephyr_graph(3, SHORE),
}
table(
    ["graph", "qubits", "couplers", "most couplers of a qubit"],
    [
        (name, graph.number_of_nodes(), graph.number_of_edges(), max(dict(graph.degree).values()))
        for name, graph in machines.items()
    ],
)

# %% [markdown]
# ## A cell of Chimera
#
# Two times four qubits, everyone of one side coupled with everyone of the other: $K_{4,4}$. Cells
# sit in a grid; one side is coupled upwards and downwards, the other to the left and the right.

# %%
cell = dnx.chimera_graph(2, 2, SHORE)
spots = dnx.chimera_layout(cell)


def picture(axes):
    """Draw four cells."""
    for a, b in cell.edges:
        axes.plot(*zip(spots[a], spots[b], strict=True), color="0.7", linewidth=0.8)
    axes.scatter(*zip(*spots.values(), strict=True), s=25, zorder=2)
    axes.set_axis_off()


draw(picture, size=(3, 3))

# %% [markdown]
# ## Counting
#
# Chimera $C_4$: 16 cells of 8 qubits. Inside a cell $4 \cdot 4$ couplers, between neighbours $4$,
# and there are $2 \cdot 4 \cdot 3$ pairs of neighbours: $16 \cdot 16 + 24 \cdot 4 = 352$. Zephyr
# is counted in the same way in the check's file. For Pegasus $P_{16}$ we take what was published,
# 5,640 qubits and 40,484 couplers (Boothby et al. 2020, arXiv 2003.00133).
#
# Two graphs with the same counts may still differ. So the check draws each of the three once more,
# by geometry: a qubit is a piece of a line, upright or flat, and where two cross there is a
# coupler. Not one of them may differ.

# %%
print(16 * 16 + 24 * 4, "couplers in C4 by counting")
numbers = ("qubits", "couplers", "wrong couplers")
verdict(CHECK, [f"{graph} {what}" for graph in ("C4", "Z3", "P16") for what in numbers])

# %% [markdown]
# ## Try it yourself
#
# 1. Count the qubits of `pegasus_graph(m)` for $m = 2 \dots 6$ and find a formula.
# 2. A real machine lacks a few qubits. Remove five at random: how many couplers go with them?
