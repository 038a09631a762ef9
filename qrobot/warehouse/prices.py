"""Prices of articles in scattered storage: a bound, and what no short tour can use.

A Lagrangian bound: whoever pays for each piece that is missing need not have enough of anything,
so that a shortest path is found by one sweep over the network.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from qrobot._arrays import Floats
from qrobot.warehouse.scattered import Network
from qrobot.warehouse.subgradient import Paths, State, compiled_search, search_prices

__all__ = ["Relaxed", "relax"]

ROUNDS, FEWER = 600, 150
"""Of the search for prices, and when it is not compiled."""

PLAIN_WORK, FEWEST = 1_000_000, 20
"""Arcs and pieces that plain Python looks at, half a second; but so many rounds in any case."""


@dataclass(frozen=True, slots=True)
class Relaxed:
    """A bound from prices of articles, and for each arc and choice the bound when it is used.

    Parameters
    ----------
    network
        The network.
    bound
        No tour is shorter, metres.
    arcs, choices
        Shape (arcs,) and (choices,): no tour that uses it is shorter.
    prices
        Shape (articles,): of a piece.
    back
        Shape (nodes,): least cost from each to the last, less the prices of what is passed.
    """

    network: Network
    bound: float
    arcs: Floats
    choices: Floats
    prices: Floats
    back: Floats

    def within(self, length: float) -> Network:
        """Return the network of what may be on a tour of at most this length."""
        old = self.network
        use, kept = self.arcs <= length, np.flatnonzero(self.choices <= length)
        ends = np.concatenate([[0], old.tails[use], old.heads[use], [old.nodes - 1]])
        names, ends = np.unique(ends, return_inverse=True)
        tails, heads = np.split(ends[1:-1], 2)
        return replace(
            old,
            nodes=len(names),
            tails=tails,
            heads=heads,
            costs=old.costs[use],
            groups=old.groups[use],
            choices=old.choices.part(kept),
        )


def relax(network: Network, *, compiled: bool = False) -> Relaxed:
    """Return the bound of the best prices that some rounds of a subgradient search find.

    Each piece has a price, and a path need no longer have enough of anything: it costs its
    length less the prices of its pieces. That, plus the prices of all that is asked for, is a
    bound.

    Parameters
    ----------
    network
        The network.
    compiled
        Whether to search with compiled kernels, and longer.
    """
    order = np.argsort(network.choices.groups, kind="stable")
    costs, pieces = network.choices.costs[order], network.choices.pieces[order]
    names, starts = np.unique(network.choices.groups[order], return_index=True)
    group = np.searchsorted(names, network.groups)
    group[network.groups < 0] = len(names)
    rows, articles = np.nonzero(pieces)
    paths = Paths(
        tails=network.tails,
        heads=network.heads,
        arcs=network.costs,
        group=group,
        starts=np.append(starts, len(order)),
        costs=costs,
        begins=np.searchsorted(rows, np.arange(len(order) + 1)),
        articles=articles,
        counts=pieces[rows, articles].astype(np.float64),
        asked=network.demand.astype(np.float64),
    )
    state = State(
        np.empty(network.nodes),
        np.full(network.nodes, np.inf),
        np.zeros(network.nodes, dtype=np.int64),
        np.zeros(len(names) + 1),
        np.zeros(len(names) + 1, dtype=np.int64),
    )
    each = costs / np.maximum(pieces.sum(axis=1), 1)
    prices = np.array([each[has].min(initial=np.inf) for has in (pieces > 0).T])
    prices[~np.isfinite(prices)] = 0.0
    search, rounds = compiled_search() if compiled else search_prices, ROUNDS
    if not compiled:
        rounds = min(FEWER, max(FEWEST, PLAIN_WORK // (len(paths.tails) + len(rows) + 1)))
    bound = search(paths, state, prices, rounds)
    if not np.isfinite(bound):
        never = np.full(len(costs), np.inf), np.full(len(paths.arcs), np.inf)
        return Relaxed(network, np.inf, never[1], never[0], prices, state.back)
    total = network.costs + state.least[group]
    ends = state.ahead[network.tails], state.back[network.heads]
    through = ends[0] + total + ends[1] + float(prices @ paths.asked)
    cheapest = np.full(len(names) + 1, np.inf)
    np.minimum.at(cheapest, group, through)
    choices = np.empty(len(costs))
    reduced = costs - pieces @ prices
    choices[order] = np.repeat(cheapest[:-1] - state.least[:-1], np.diff(paths.starts)) + reduced
    return Relaxed(network, bound, through, choices, prices, state.back)
