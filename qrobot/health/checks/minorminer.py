"""minorminer: a complete graph of five fits on a small lattice; the embedding is verified."""

import itertools

from qrobot.health.check import Check

SIDE = 4
"""Of the target, a square lattice with both diagonals."""


def lattice() -> set[tuple[int, int]]:
    """Return the edges of the target, both ways."""
    steps = ((0, 1), (1, 0), (1, 1), (1, -1))
    edges = set()
    for row, column in itertools.product(range(SIDE), repeat=2):
        for down, right in steps:
            if row + down < SIDE and 0 <= column + right < SIDE:
                pair = (row * SIDE + column, (row + down) * SIDE + column + right)
                edges |= {pair, pair[::-1]}
    return edges


def answer() -> list[float]:
    """Return how many chains are there, hang together and share nothing, and edges covered."""
    import minorminer

    source = list(itertools.combinations(range(5), 2))
    edges = lattice()
    found = minorminer.find_embedding(source, sorted(edges), random_seed=3, tries=50)
    chains = {node: set(chain) for node, chain in found.items()}
    connected = sum(_hangs_together(chain, edges) for chain in chains.values())
    used = [node for chain in chains.values() for node in chain]
    covered = sum(
        any((a, b) in edges for a in chains.get(i, ()) for b in chains.get(j, ()))
        for i, j in source
    )
    return [len(chains), connected, len(used) - len(set(used)), covered]


def expected() -> list[float]:
    """Return five chains, none broken, none shared, ten edges."""
    return [5, 5, 0, 10]


def _hangs_together(chain: set[int], edges: set[tuple[int, int]]) -> bool:
    reached = set(sorted(chain)[:1])
    for _ in chain:
        reached |= {b for a, b in edges if a in reached and b in chain}
    return bool(chain) and reached == chain


CHECK = Check(
    __name__,
    title="an embedding, verified",
    group="annealing",
    imports=("minorminer",),
    source="the definition of a minor: chains hang together, are apart, cover 5 * 4 / 2 edges",
    extra="dwave",
)
