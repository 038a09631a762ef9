"""dwave-networkx: the QPUs' graphs, coupler by coupler.

A qubit is a piece of a line, upright (side 0) or flat (side 1); where two cross there is a coupler.
"""

import itertools
from collections.abc import Iterator

from qrobot.health.check import Check

Node = tuple[int, ...]
Coupler = tuple[Node, Node]

CELLS, SHORE = 4, 4
ZEPHYR, PEGASUS = 3, 16

STARTS = ((2, 2, 2, 2, 10, 10, 10, 10, 6, 6, 6, 6), (6, 6, 6, 6, 2, 2, 2, 2, 10, 10, 10, 10))
"""Where the twelve upright and flat lines of a Pegasus cell begin (Boothby et al. 2020)."""


def chimera() -> Iterator[Coupler]:
    """Give the couplers of C4; a qubit is (row, column, side, number)."""
    for row, column in itertools.product(range(CELLS), repeat=2):
        for k in range(SHORE):
            yield from (((row, column, 0, k), (row, column, 1, n)) for n in range(SHORE))
            if row + 1 < CELLS:
                yield (row, column, 0, k), (row + 1, column, 0, k)
            if column + 1 < CELLS:
                yield (row, column, 1, k), (row, column + 1, 1, k)


def zephyr() -> Iterator[Coupler]:
    """Give the couplers of Z3; a qubit (side, line, number, half, z) begins at 2 z + half."""
    lines, both = range(2 * ZEPHYR + 1), itertools.product(range(SHORE), repeat=2)
    for side, line, k, z in itertools.product((0, 1), lines, range(SHORE), range(ZEPHYR)):
        yield (side, line, k, 0, z), (side, line, k, 1, z)  # half a length apart
        if z + 1 < ZEPHYR:
            yield (side, line, k, 1, z), (side, line, k, 0, z + 1)
            yield from (((side, line, k, j, z), (side, line, k, j, z + 1)) for j in (0, 1))
    ends = range(2 * ZEPHYR)
    for (k, n), x, y in itertools.product(both, ends, ends):  # begins at y; begins at x
        for right, down in itertools.product((0, 1), repeat=2):  # each is two lines long
            yield (0, x + right, k, y % 2, y // 2), (1, y + down, n, x % 2, x // 2)


def pegasus() -> Iterator[Coupler]:
    """Give the couplers of P16; a qubit is (side, cell, number, z), twelve lines long.

    At the rim are qubits that cross no other; they are left out.
    """
    crossings = list(_crossings())
    yield from crossings
    qubits = set(itertools.chain.from_iterable(crossings))
    for side, cell, k, z in qubits:
        for other in ((side, cell, k, z + 1), (side, cell, k + 1 - k % 2, z)):
            if other in qubits and other != (side, cell, k, z):
                yield (side, cell, k, z), other


def _crossings() -> Iterator[Coupler]:
    count = PEGASUS - 1
    for cell, k, z in itertools.product(range(PEGASUS), range(12), range(count)):
        begin = 12 * z + STARTS[0][k]
        for across, n in (divmod(line, 12) for line in range(begin, begin + 12)):
            place = (12 * cell + k - STARTS[1][n]) // 12
            if 0 <= place < count:
                yield (0, cell, k, z), (1, across, n, place)


def answer() -> list[float]:
    """Return nodes, edges, and edges that are wrong or missing, of C4, Z3 and P16."""
    import dwave_networkx as graphs

    made = (
        (graphs.chimera_graph(CELLS, CELLS, SHORE, coordinates=True), chimera()),
        (graphs.zephyr_graph(ZEPHYR, SHORE, coordinates=True), zephyr()),
        (graphs.pegasus_graph(PEGASUS, coordinates=True), pegasus()),
    )
    found: list[float] = []
    for graph, couplers in made:
        wrong = {frozenset(pair) for pair in graph.edges} ^ set(map(frozenset, couplers))
        found += [graph.number_of_nodes(), graph.number_of_edges(), len(wrong)]
    return found


def expected() -> list[float]:
    """Return the counts by formula, those that D-Wave published, and no wrong edge."""
    chimera_nodes = 2 * CELLS * CELLS * SHORE
    chimera_edges = CELLS * CELLS * SHORE**2 + 2 * SHORE * CELLS * (CELLS - 1)
    # A Zephyr Zm has 2 (2 m + 1) t lines of 2 m qubits, two rows of m in brick pattern; a qubit
    # is two cells long, so of 4 m * 4 m half cells every one holds t * t crossings.
    m, t = ZEPHYR, SHORE
    lines = 2 * (2 * m + 1) * t
    zephyr_nodes = lines * 2 * m
    crossings, ends, overlaps = (4 * m * t) ** 2, lines * 2 * (m - 1), lines * (2 * m - 1)
    zephyr_edges = crossings + ends + overlaps
    return [chimera_nodes, chimera_edges, 0, zephyr_nodes, zephyr_edges, 0, 5640, 40484, 0]


CHECK = Check(
    __name__,
    title="graphs of the QPUs",
    group="annealing",
    imports=("dwave_networkx",),
    distributions=("dwave-networkx",),
    source="counting and lines that cross; P16: Boothby et al. 2020, arXiv 2003.00133",
    extra="dwave",
)
