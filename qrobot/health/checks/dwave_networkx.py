"""dwave-networkx: the sizes of the QPUs' graphs."""

from __future__ import annotations

import importlib
from typing import Any

from qrobot.health.check import Check

CELLS, SHORE = 4, 4


def answer() -> list[float]:
    """Return nodes and edges of Chimera C4, Zephyr Z3 and Pegasus P16."""
    graphs: Any = importlib.import_module("dwave_networkx")
    made = [
        graphs.chimera_graph(CELLS, CELLS, SHORE),
        graphs.zephyr_graph(3, SHORE),
        graphs.pegasus_graph(16),
    ]
    return [float(n) for g in made for n in (g.number_of_nodes(), g.number_of_edges())]


def expected() -> list[float]:
    """Return the counts by formula, and those that D-Wave published."""
    chimera_nodes = 2 * CELLS * CELLS * SHORE
    chimera_edges = CELLS * CELLS * SHORE**2 + 2 * SHORE * CELLS * (CELLS - 1)
    # A Zephyr Zm has 2 (2 m + 1) t lines of 2 m qubits, two rows of m in brick pattern; a qubit
    # is two cells long, so of 4 m * 4 m half cells every one holds t * t crossings.
    m, t = 3, SHORE
    lines = 2 * (2 * m + 1) * t
    zephyr_nodes = lines * 2 * m
    crossings, ends, overlaps = (4 * m * t) ** 2, lines * 2 * (m - 1), lines * (2 * m - 1)
    zephyr_edges = crossings + ends + overlaps
    return [chimera_nodes, chimera_edges, zephyr_nodes, zephyr_edges, 5640, 40484]


CHECK = Check(
    module=__name__,
    title="graphs of the QPUs",
    group="annealing",
    imports=("dwave_networkx",),
    distributions=("dwave-networkx",),
    answer=answer,
    expected=expected,
    source="counting for C4 and Z3; P16: Boothby et al. 2020, arXiv 2003.00133",
    extra="dwave",
)
