"""Shortest paths through a network of places that pass enough of every article, by labels.

A label is a path from the first node to another and what it has collected. Prices of the articles
say what a label must still pay at least; what cannot end within a limit is dropped, and so is a
label that costs no less than another of its node and has no more of any article.
Importing this module imports numba.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Bools, Floats, Ints
from qrobot._jit import compile_kernel
from qrobot.warehouse.prices import Relaxed

__all__ = ["shortest_within"]

FIRST, GROWTH, LABELS = 20_000, 5, 100_000
"""Room for labels at first, its growth, and the most: hundredths of a second for ten thousand."""

COMPARED = 300
"""Cheapest labels of a node that another is compared with."""

MANY = 255
"""Pieces of an article that a label can count."""


def shortest_within(relaxed: Relaxed, limit: float) -> tuple[float, set[int]] | None:
    """Return the length of a shortest tour and the offers that it passes.

    Parameters
    ----------
    relaxed
        The network with its prices.
    limit
        Longer tours are not looked for.

    Returns
    -------
    tuple or None
        ``inf`` and nothing when every tour is longer. None when there are too many labels.
    """
    network = relaxed.network
    choices = network.choices
    if not len(network.tails) or network.demand.max(initial=0) > MANY:
        return None
    question, kept = _question(relaxed, limit)
    room = FIRST
    while True:
        last, length, labels = _label(question, limit, room, COMPARED)
        if last >= -1:
            break
        if room >= LABELS:
            return None
        room *= GROWTH
    if last < 0:
        return np.inf, set()
    offers: set[int] = set()
    while last > 0:
        choice = labels.taken[last]
        if choice < len(kept):
            offers |= choices.offers(kept[choice])
        last = labels.parents[last]
    return float(length), offers


class _Question(NamedTuple):
    """Arcs and choices that may be on a short tour; the last choice is none, and costs nothing.

    Parameters
    ----------
    tails, arcs, group
        Shape (arcs,): node before, cost, and the group of choices.
    ends
        Shape (nodes + 1,): the arcs into each node begin here.
    starts
        Shape (groups + 1,): the choices of each group begin here.
    costs, pieces
        Of each choice, shapes (choices,) and (choices, articles).
    back, prices, demand
        As of `Relaxed` and `Network`.
    """

    tails: Ints
    arcs: Floats
    group: Ints
    ends: Ints
    starts: Ints
    costs: Floats
    pieces: Ints
    back: Floats
    prices: Floats
    demand: Ints


def _question(relaxed: Relaxed, limit: float) -> tuple[_Question, Ints]:
    """Return what may be on a tour within a limit, and the numbers of its choices."""
    network, choices = relaxed.network, relaxed.network.choices
    kept = np.flatnonzero(relaxed.choices <= limit)
    kept = kept[np.argsort(choices.groups[kept], kind="stable")]
    names, starts = np.unique(choices.groups[kept], return_index=True)
    none = len(names)
    group = np.searchsorted(names, network.groups)
    group[network.groups < 0] = none
    # The name of no group is that of no choice.
    same = np.append(names, -1)[group] == network.groups
    use = (relaxed.arcs <= limit) & same
    question = _Question(
        tails=network.tails[use],
        arcs=network.costs[use],
        group=group[use],
        ends=np.searchsorted(network.heads[use], np.arange(network.nodes + 1)),
        starts=np.concatenate([starts, [len(kept), len(kept) + 1]]),
        costs=np.append(choices.costs[kept], 0.0),
        pieces=np.vstack([choices.pieces[kept], np.zeros_like(network.demand)]),
        back=relaxed.back,
        prices=relaxed.prices,
        demand=network.demand,
    )
    return question, kept


def _better(
    costs: Floats, has: npt.NDArray[np.uint8], first: int, last: int, keep: Bools, compared: int
) -> None:
    """Say which labels of a node no other one replaces."""
    order = np.argsort(costs[first:last])
    best = np.empty(min(compared, last - first), dtype=np.int64)
    count = 0
    for at in order:
        label, kept = first + at, True
        for k in range(count):
            other, more = best[k], True
            for article in range(has.shape[1]):
                if has[other, article] < has[label, article]:
                    more = False
                    break
            if more:
                kept = False
                break
        keep[at] = kept
        if kept and count < len(best):
            best[count] = label
            count += 1


_better = compile_kernel(_better, inner=True)


class _Labels(NamedTuple):
    """What was paid, what must still be paid at least, what is collected, and from where."""

    paid: Floats
    owed: Floats
    has: npt.NDArray[np.uint8]
    parents: Ints
    taken: Ints


def _owes(labels: _Labels, label: int, pieces: Ints, prices: Floats, demand: Ints) -> float:
    """Return what a label owes when it has collected more pieces."""
    owes = labels.owed[label]
    for article in range(len(demand)):
        left = demand[article] - labels.has[label, article]
        owes -= prices[article] * min(left, pieces[article])
    return float(owes)


_owes = compile_kernel(_owes, inner=True)


def _extend(
    labels: _Labels, span: tuple[int, int], question: _Question, arc: int, room: float, count: int
) -> int:
    """Extend labels of one node by an arc; return how many there are, -2 when too many.

    `room` is the most that a label may pay and owe.
    """
    which = question.group[arc]
    low, high = question.starts[which], question.starts[which + 1]
    for label in range(span[0], span[1]):
        for choice in range(low, high):
            cost = labels.paid[label] + question.arcs[arc] + question.costs[choice]
            if cost > room:
                continue
            owes = _owes(labels, label, question.pieces[choice], question.prices, question.demand)
            if cost + owes > room:
                continue
            if count == len(labels.paid):
                return -2
            labels.paid[count], labels.owed[count] = cost, owes
            labels.parents[count], labels.taken[count] = label, choice
            for article in range(len(question.demand)):
                now = labels.has[label, article] + question.pieces[choice, article]
                labels.has[count, article] = min(question.demand[article], now)
            count += 1
    return count


_extend = compile_kernel(_extend, inner=True)


def _pack(labels: _Labels, first: int, count: int, compared: int) -> int:
    """Keep the labels of a node that no other one replaces; return how many there are."""
    keep = np.ones(count - first, dtype=np.bool_)
    _better(labels.paid, labels.has, first, count, keep, compared)
    kept = first
    for label in range(first, count):
        if keep[label - first]:
            labels.paid[kept], labels.owed[kept] = labels.paid[label], labels.owed[label]
            labels.parents[kept], labels.taken[kept] = labels.parents[label], labels.taken[label]
            labels.has[kept] = labels.has[label]
            kept += 1
    return kept


_pack = compile_kernel(_pack, inner=True)


def _label(
    question: _Question, limit: float, room: int, compared: int
) -> tuple[int, float, _Labels]:
    """Make the labels node by node, at most `room`.

    Returns
    -------
    tuple
        The best label of the last node, -1 when there is none, -2 when there are too many; its
        length; all labels.
    """
    nodes, articles = len(question.ends) - 1, len(question.demand)
    labels = _Labels(
        np.empty(room),
        np.empty(room),
        np.zeros((room, articles), dtype=np.uint8),
        np.zeros(room, dtype=np.int64),
        np.full(room, -1, dtype=np.int64),
    )
    begins = np.zeros(nodes + 1, dtype=np.int64)
    lasts = np.zeros(nodes + 1, dtype=np.int64)
    labels.paid[0], labels.owed[0] = 0.0, (question.prices * question.demand).sum()
    count, lasts[0] = 1, 1
    for node in range(1, nodes):
        begins[node] = count
        for arc in range(question.ends[node], question.ends[node + 1]):
            tail = question.tails[arc]
            span = (begins[tail], lasts[tail])
            count = _extend(labels, span, question, arc, limit - question.back[node], count)
            if count < 0:
                return -2, np.inf, labels
        count = _pack(labels, begins[node], count, compared)
        lasts[node] = count
    best, least = -1, np.inf
    for label in range(begins[nodes - 1], lasts[nodes - 1]):
        enough = True
        for article in range(articles):
            enough &= labels.has[label, article] >= question.demand[article]
        if enough and labels.paid[label] < least:
            best, least = label, labels.paid[label]
    return best, least, labels


_label = compile_kernel(_label)
