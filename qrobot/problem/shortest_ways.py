"""Shortest ways over a graph of many nodes, by SciPy: lengths, and the nodes passed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot._extras import load
from qrobot.errors import InputError

__all__ = ["MAX_VISITS", "Network"]

MAX_VISITS = 2.5e8
"""Nodes times places of a table of distances at most: minutes of SciPy's Dijkstra."""

AT_ONCE = 4_000_000
"""Lengths that are kept at a time, 8 bytes each."""


class Network:
    """A directed graph whose arcs have lengths.

    Parameters
    ----------
    nodes
        How many there are.
    tails, heads, lengths
        Of each arc: the node that it leaves, the node that it enters, and how long it is.
    what
        What asks for it, for the error where SciPy is not installed.
    """

    def __init__(
        self,
        nodes: int,
        tails: npt.NDArray[np.int32],
        heads: npt.NDArray[np.int32],
        lengths: Floats,
        what: str,
    ) -> None:
        sparse = load("scipy.sparse", what)
        self._search = load("scipy.sparse.csgraph", what)
        # Of two arcs between the same nodes the shorter counts: the matrix would add them up.
        order = np.lexsort((lengths, heads, tails))
        tails, heads, lengths = tails[order], heads[order], lengths[order]
        first = np.ones(len(order), dtype=bool)
        first[1:] = (np.diff(tails) != 0) | (np.diff(heads) != 0)
        self._graph: Any = sparse.csr_array(
            (lengths[first], (tails[first], heads[first])), shape=(nodes, nodes)
        )
        self._rows: dict[int, int] = {}
        self._table: Floats = np.zeros((0, 0))

    def between(self, nodes: Sequence[int]) -> Floats:
        """Return the lengths of shortest ways between nodes, ``inf`` where none leads.

        Raises
        ------
        InputError
            When it would take too long.
        """
        wanted = sorted(set(nodes))
        if not all(node in self._rows for node in wanted):
            size = self._graph.shape[0]
            if len(wanted) * size > MAX_VISITS:
                raise InputError(
                    f"{len(wanted)} places on {size} nodes of the map would take too long",
                    field="warehouse.cell",
                    advice="plan on coarser cells, or in waves",
                )
            columns = np.array(wanted)
            step = max(1, AT_ONCE // max(1, size))
            parts = [
                self._search.dijkstra(self._graph, indices=columns[k : k + step])[:, columns]
                for k in range(0, len(columns), step)
            ]
            # Kept: the same places are asked for by each instance that is made of another.
            self._rows = {node: row for row, node in enumerate(wanted)}
            self._table = np.concatenate(parts)
        rows = [self._rows[node] for node in nodes]
        return np.asarray(self._table[np.ix_(rows, rows)])

    def way(self, start: int, end: int) -> list[int]:
        """Return the nodes of a shortest way, both ends with it; empty where none leads."""
        if start == end:
            return [start]
        limit = np.inf
        if start in self._rows and end in self._rows:
            limit = self._table[self._rows[start], self._rows[end]] * (1 + 1e-9)
        if np.isinf(limit) and start in self._rows and end in self._rows:
            return []
        _, before = self._search.dijkstra(
            self._graph, indices=start, return_predecessors=True, limit=limit
        )
        found = [end]
        while found[-1] != start:
            if before[found[-1]] < 0:
                return []
            found.append(int(before[found[-1]]))
        return found[::-1]
