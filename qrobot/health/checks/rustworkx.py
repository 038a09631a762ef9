"""rustworkx: shortest ways, a spanning tree and a matching."""

import itertools

from qrobot.health.check import Check

EDGES = ((0, 1, 7), (0, 2, 3), (1, 2, 1), (1, 3, 2), (2, 3, 8), (3, 4, 2), (2, 4, 9), (0, 5, 4),
         (4, 5, 6))  # fmt: skip
NODES = 6


def answer() -> list[float]:
    """Return all shortest ways, the weight of the least tree and of the heaviest matching."""
    import rustworkx

    graph = rustworkx.PyGraph()
    graph.add_nodes_from(range(NODES))
    graph.add_edges_from([(a, b, float(w)) for a, b, w in EDGES])
    ways = rustworkx.floyd_warshall_numpy(graph, weight_fn=float)
    tree = rustworkx.minimum_spanning_edges(graph, weight_fn=float)
    pairs = rustworkx.max_weight_matching(graph, weight_fn=int)
    matched = sum(w for a, b, w in EDGES if (a, b) in pairs or (b, a) in pairs)
    return [*ways.ravel().tolist(), sum(w for _, _, w in tree), float(matched)]


def expected() -> list[float]:
    """Return the same: relaxation until nothing changes, and all sets of edges."""
    far = float("inf")
    ways = [[0.0 if a == b else far for b in range(NODES)] for a in range(NODES)]
    for a, b, w in EDGES:
        ways[a][b] = ways[b][a] = w
    for via, a, b in itertools.product(range(NODES), repeat=3):
        ways[a][b] = min(ways[a][b], ways[a][via] + ways[via][b])
    tree = min(
        sum(w for _, _, w in edges)
        for edges in itertools.combinations(EDGES, NODES - 1)
        if _reaches_all([(a, b) for a, b, _ in edges])
    )
    matching = max(
        sum(w for _, _, w in edges)
        for size in range(NODES // 2 + 1)
        for edges in itertools.combinations(EDGES, size)
        if len({node for a, b, _ in edges for node in (a, b)}) == 2 * size
    )
    return [*(way for row in ways for way in row), tree, matching]


def _reaches_all(edges: list[tuple[int, int]]) -> bool:
    reached = {0}
    for _ in range(NODES):
        reached |= {n for edge in edges if reached & set(edge) for n in edge}
    return len(reached) == NODES


CHECK = Check(
    __name__,
    title="ways, tree and matching",
    group="gate model",
    imports=("rustworkx",),
    source="all sets of edges, in plain Python",
    extra="qiskit",
)
