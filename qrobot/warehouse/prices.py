"""Prices of articles in scattered storage: a bound, and what no short tour can use.

A Lagrangian bound: whoever pays for each piece that is missing need not have enough of anything,
so that a shortest path is found by one sweep over the network.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from qrobot import _jit
from qrobot._arrays import Floats
from qrobot.warehouse.scattered import Choices, Network

__all__ = ["Relaxed", "relax"]

ROUNDS = 150
"""Of the search for prices."""
PATIENCE, SHORTER = 8, 0.6
"""After so many rounds without a better bound the steps become shorter by this factor."""


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
            choices=Choices(
                old.choices.groups[kept],
                old.choices.costs[kept],
                old.choices.pieces[kept],
                tuple(old.choices.offers[k] for k in kept),
            ),
        )


def relax(network: Network) -> Relaxed:
    """Return the bound of the best prices that some rounds of a subgradient search find.

    Each piece has a price, and a path need no longer have enough of anything: it costs its
    length less the prices of its pieces. That, plus the prices of all that is asked for, is a
    bound.
    """
    order = np.argsort(network.choices.groups, kind="stable")
    costs = network.choices.costs[order]
    pieces = network.choices.pieces[order].astype(np.float64)
    names, starts = np.unique(network.choices.groups[order], return_index=True)
    sizes = np.diff(np.append(starts, len(order)))
    group = np.searchsorted(names, network.groups)
    group[network.groups < 0] = len(names)  # the last one costs nothing
    least = np.zeros(len(names) + 1)
    ahead, back = np.empty(network.nodes), np.empty(network.nodes)
    came = np.zeros(network.nodes, dtype=np.int64)
    asked = network.demand.astype(np.float64)
    sweep = _kernel()

    def path(prices: Floats, *, both: bool = False) -> tuple[Floats, Floats]:
        """Sweep at given prices; return what choices and arcs then cost."""
        reduced = costs - pieces @ prices
        least[:-1] = np.minimum.reduceat(reduced, starts) if len(order) else 0.0
        total = network.costs + least[group]
        sweep(network.tails, network.heads, total, ahead, came, back, both)
        return reduced, total

    prices = np.zeros(len(asked))
    per_piece = costs / np.maximum(pieces.sum(axis=1), 1.0)
    for article in range(len(asked)):
        prices[article] = per_piece[pieces[:, article] > 0].min(initial=np.inf)
    prices[~np.isfinite(prices)] = 0.0
    best, chosen, scale, stalled = 0.0, np.zeros(len(asked)), 1.0, 0
    for _ in range(ROUNDS):
        reduced, _ = path(prices)
        value = float(ahead[-1] + prices @ asked)
        if not np.isfinite(value):
            never = np.full(len(costs), np.inf)
            return Relaxed(network, np.inf, ahead[network.tails], never, prices, back)
        stalled = 0 if value > best * 1.001 else stalled + 1
        if value > best:
            best, chosen = value, prices
        if stalled >= PATIENCE:
            scale, stalled = scale * SHORTER, 0
        missing, node = asked.copy(), network.nodes - 1
        while node:
            arc = came[node]
            if group[arc] < len(names):
                first = starts[group[arc]]
                pick = first + int(np.argmin(reduced[first : first + sizes[group[arc]]]))
                missing -= pieces[pick]
            node = network.tails[arc]
        missing[(prices <= 0.0) & (missing < 0.0)] = 0.0
        square = float(missing @ missing)
        if square == 0.0:
            break
        # Polyak's step towards a value a little above the best bound.
        prices = np.maximum(0.0, prices + scale * (best * 1.03 + 1.0 - value) / square * missing)
    reduced, total = path(chosen, both=True)
    add = float(chosen @ asked)
    arcs = ahead[network.tails] + total + back[network.heads] + add
    cheapest = np.full(len(names) + 1, np.inf)
    np.minimum.at(cheapest, group, arcs)
    choices = np.empty(len(costs))
    choices[order] = np.repeat(cheapest[:-1] - least[:-1], sizes) + reduced
    return Relaxed(network, float(ahead[-1]) + add, arcs, choices, chosen, back)


def _sweep(tails: Any, heads: Any, costs: Any, ahead: Any, came: Any, back: Any, both: Any) -> None:
    """Find the least costs from the first node to each, and where asked to the last."""
    ahead[:] = np.inf
    ahead[0] = 0.0
    for arc in range(len(tails)):
        cost = ahead[tails[arc]] + costs[arc]
        if cost < ahead[heads[arc]]:
            ahead[heads[arc]] = cost
            came[heads[arc]] = arc
    if both:
        back[:] = np.inf
        back[-1] = 0.0
        for arc in range(len(tails) - 1, -1, -1):
            cost = back[heads[arc]] + costs[arc]
            if cost < back[tails[arc]]:
                back[tails[arc]] = cost


@cache
def _kernel() -> Callable[..., None]:
    """Return the sweep, compiled where numba is installed."""
    return _jit.compile_kernel(_sweep) if _jit.available() else _sweep
