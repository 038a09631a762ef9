# %% [markdown]
# # Graphs in Rust: rustworkx
#
# Qiskit sees a machine as a graph of qubits and asks rustworkx for shortest ways, trees and
# matchings when it places a circuit. A warehouse is a graph too. In 2021 a Pi needed a Rust
# toolchain to build it; today it is a wheel.

# %%
import rustworkx as rx

from qrobot.health.checks.rustworkx import CHECK, EDGES, NODES
from qrobot.health.lesson import draw, table, verdict

graph = rx.PyGraph()
graph.add_nodes_from(range(NODES))
graph.add_edges_from([(a, b, float(w)) for a, b, w in EDGES])
spots = rx.circular_layout(graph)


def picture(axes):
    """Draw all ways, those of the least tree thick."""
    tree = {(a, b) for a, b, _ in rx.minimum_spanning_edges(graph, weight_fn=float)}
    for a, b, weight in EDGES:
        (x, y), (u, v) = spots[a], spots[b]
        axes.plot([x, u], [y, v], color="C0" if (a, b) in tree else "0.8", linewidth=2)
        axes.text((x + u) / 2, (y + v) / 2, weight)
    for node in range(NODES):
        axes.annotate(str(node), spots[node], ha="center", va="center", bbox={"boxstyle": "circle"})
    axes.set_axis_off()


draw(picture, size=(3.2, 3.2))

# %% [markdown]
# ## Three questions to one graph
#
# - **Shortest ways** from everywhere to everywhere (Floyd and Warshall). From 0 to 1 the direct
#   way costs 7, by way of 2 it is 4.
# - **The least spanning tree**: the cheapest edges that hold all nodes together.
# - **The heaviest matching**: pairs of neighbours, nobody in two pairs, of largest total weight.

# %%
ways = rx.floyd_warshall_numpy(graph, weight_fn=float)
table(["from", *map(str, range(NODES))], [(k, *map(float, row)) for k, row in enumerate(ways)])
print("matching:", sorted(rx.max_weight_matching(graph, weight_fn=int)))

# %% [markdown]
# ## The check
#
# Six nodes and nine edges are few: the check tries every set of edges for the tree and for the
# matching, and relaxes the ways in three loops of plain Python.

# %%
pairs = [f"way {a} to {b}" for a in range(NODES) for b in range(NODES)]
verdict(CHECK, [*pairs, "least tree", "heaviest matching"])

# %% [markdown]
# ## Try it yourself
#
# 1. Find the way itself with `rx.dijkstra_shortest_paths(graph, 0, weight_fn=float)`.
# 2. Add an edge of negative weight. Which of the three questions still has an answer?
