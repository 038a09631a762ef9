"""The search for prices of articles in scattered storage, in plain Python and compiled.

A subgradient search: what a shortest path has too little of becomes dearer. Each step aims at a
level above the best bound, which comes down when the bound does not follow, and goes on in the
direction of the steps before it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import NamedTuple

import numpy as np

from qrobot import _jit
from qrobot._arrays import Floats, Ints

__all__ = ["Paths", "State", "compiled_search", "search_prices"]

PATIENCE, MEMORY = 25, 0.8
"""After so many rounds without a better bound the level comes down by half; this share of the last
direction is kept."""

AIM, ENOUGH = 0.1, 0.001
"""The level is above the best bound by this share at first, and by this share at last."""


class Paths(NamedTuple):
    """A network for sweeps: choices in the sequence of their groups, pieces without zeros.

    Parameters
    ----------
    tails, heads, arcs, group
        Shape (arcs,): nodes, costs and groups; the last group is none, and costs nothing.
    starts
        Shape (groups + 1,): the choices of each group begin here.
    costs
        Shape (choices,).
    begins
        Shape (choices + 1,): the pieces of each choice begin here.
    articles, counts
        What they are and how many.
    asked
        Shape (articles,).
    """

    tails: Ints
    heads: Ints
    arcs: Floats
    group: Ints
    starts: Ints
    costs: Floats
    begins: Ints
    articles: Ints
    counts: Floats
    asked: Floats


class State(NamedTuple):
    """What a sweep finds.

    Parameters
    ----------
    ahead, back
        Shape (nodes,): least costs from the first node and to the last.
    came
        Shape (nodes,): the arc that each is reached by.
    least, pick
        Shape (groups + 1,): the best choice of each group, its cost and number.
    """

    ahead: Floats
    back: Floats
    came: Ints
    least: Floats
    pick: Ints


def _ahead(paths: Paths, state: State, prices: Floats) -> float:
    """Find the least costs from the first node at given prices; return the bound."""
    for group in range(len(paths.starts) - 1):
        low = np.inf
        for choice in range(paths.starts[group], paths.starts[group + 1]):
            cost = paths.costs[choice]
            for k in range(paths.begins[choice], paths.begins[choice + 1]):
                cost -= paths.counts[k] * prices[paths.articles[k]]
            if cost < low:
                low, state.pick[group] = cost, choice
        state.least[group] = low
    state.ahead[:] = np.inf
    state.ahead[0] = 0.0
    for arc in range(len(paths.tails)):
        cost = state.ahead[paths.tails[arc]] + paths.arcs[arc] + state.least[paths.group[arc]]
        if cost < state.ahead[paths.heads[arc]]:
            state.ahead[paths.heads[arc]] = cost
            state.came[paths.heads[arc]] = arc
    return float(state.ahead[-1] + (prices * paths.asked).sum())


def _behind(paths: Paths, state: State) -> None:
    """Find the least costs to the last node, at the prices of the last sweep."""
    state.back[:] = np.inf
    state.back[-1] = 0.0
    for arc in range(len(paths.tails) - 1, -1, -1):
        cost = state.back[paths.heads[arc]] + paths.arcs[arc] + state.least[paths.group[arc]]
        if cost < state.back[paths.tails[arc]]:
            state.back[paths.tails[arc]] = cost


def _missing(paths: Paths, state: State) -> Floats:
    """Return how many pieces of each article the shortest path has too little; below 0: more."""
    missing = paths.asked.copy()
    node = len(state.ahead) - 1
    while node:
        arc = state.came[node]
        group = paths.group[arc]
        if group < len(paths.starts) - 1:
            choice = state.pick[group]
            for k in range(paths.begins[choice], paths.begins[choice + 1]):
                missing[paths.articles[k]] -= paths.counts[k]
        node = paths.tails[arc]
    return missing


def search_prices(paths: Paths, state: State, prices: Floats, rounds: int) -> float:
    """Return the best bound, its prices in place of the first ones; the state is theirs."""
    now = prices.copy()
    direction = np.zeros(len(now))
    best = base = -np.inf
    aim, stalled = 0.0, 0
    for turn in range(rounds):
        value = _ahead(paths, state, now)
        if not np.isfinite(value):
            return np.inf
        if value > best:
            best = value
            prices[:] = now
        if turn == 0:
            aim, base = AIM * value + 1.0, value
        stalled += 1
        if best >= base + aim / 2:
            aim, base, stalled = 1.5 * aim, best, 0
        elif stalled > PATIENCE:
            aim, base, stalled = aim / 2, best, 0
            now[:] = prices
            direction[:] = 0.0
            if aim < ENOUGH * best:
                break
            continue
        direction = _missing(paths, state) + MEMORY * direction
        direction[(now <= 0.0) & (direction < 0.0)] = 0.0
        square = (direction * direction).sum()
        if square == 0.0:
            break
        now = np.maximum(0.0, now + (best + aim - value) / square * direction)
    best = _ahead(paths, state, prices)
    _behind(paths, state)
    return best


@cache
def compiled_search() -> Callable[[Paths, State, Floats, int], float]:
    """Return `search_prices` compiled: a copy that knows the compiled sweeps by the same names."""
    sweeps = {
        sweep.__name__: _jit.compile_kernel(sweep, inner=True)
        for sweep in (_ahead, _behind, _missing)
    }
    copy = FunctionType(search_prices.__code__, {**globals(), **sweeps})
    return _jit.compile_kernel(copy)
