"""Places and tour together, for articles that lie in several places: a network of choices.

The sweep's states (`states`) are the nodes of a network, the choices for sub-aisles and segments
its arcs, and a tour is a path through it. In each sub-aisle the choice also says how far it is
entered, and so which places are passed; the places on the path must have enough of every article
(Hessler and Irnich 2022). Here the network is built; choices that another one replaces are
left out. `prices` makes it smaller, a solver of whole-number programmes finds the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import gcd, lcm

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.grid import Grid, grid_of, positions_of
from qrobot.warehouse.states import PLAIN
from qrobot.warehouse.sweep import Ends, Numbers, flatten

__all__ = ["Choices", "Network", "Offer", "network_of", "step_of"]

KINDS = ("none", "pass", "twice", "front", "back", "both")
"""The first of `states.VERTICAL`, those that are possible anywhere."""


CHUNK = 256
"""Choices that are compared with each other at once."""


@dataclass(frozen=True, slots=True)
class Offer:
    """Pieces of an article that could be taken in a place.

    Parameters
    ----------
    article
        Index of the article.
    slot
        The place.
    quantity
        How many there are.
    """

    article: int
    slot: Slot
    quantity: int


@dataclass(frozen=True, slots=True)
class Choices:
    """What can be done in sub-aisles so that places are passed.

    Parameters
    ----------
    groups
        Shape (n,): which sub-aisle and kind each belongs to, as `Network.groups` counts them.
    costs
        Shape (n,), metres.
    pieces
        Shape (n, articles): what can be taken, at most what is asked for.
    cuts
        Shape (n, 4): the offers on the way of each are two spans of `along`.
    along
        Indices of offers, sub-aisle by sub-aisle from its front.
    """

    groups: Numbers
    costs: Floats
    pieces: Numbers
    cuts: Numbers
    along: Numbers

    def offers(self, choice: int) -> set[int]:
        """Return the indices of the offers on the way of a choice."""
        first, front, back, last = self.cuts[choice]
        return {*self.along[first:front].tolist(), *self.along[back:last].tolist()}

    def part(self, kept: Numbers) -> Choices:
        """Return some of the choices."""
        return Choices(
            self.groups[kept], self.costs[kept], self.pieces[kept], self.cuts[kept], self.along
        )


@dataclass(frozen=True, slots=True)
class Network:
    """Paths from node 0 to the last node are tours.

    Parameters
    ----------
    nodes
        Their number.
    tails, heads
        Shape (arcs,): nodes, in rising sequence of the heads.
    costs
        Shape (arcs,), metres, without those of choices.
    groups
        Shape (arcs,): the group whose choice an arc needs; -1: none.
    choices
        What each group offers.
    demand
        Shape (articles,).
    """

    nodes: int
    tails: Numbers
    heads: Numbers
    costs: Floats
    groups: Numbers
    choices: Choices
    demand: Numbers


def network_of(
    warehouse: AisleWarehouse, offers: Sequence[Offer], demand: Sequence[int]
) -> Network:
    """Return the network of a layout, what lies there, and what is asked for.

    Parameters
    ----------
    warehouse
        At most six cross aisles.
    offers
        What lies where.
    demand
        Pieces asked for of each article.
    """
    asked = np.array(demand, dtype=np.int64)
    useful = [i for i, offer in enumerate(offers) if asked[offer.article] > 0]
    parts, offsets = positions_of(warehouse, [offers[i].slot for i in useful])
    grid, parts = _without_empty(grid_of(warehouse), parts)
    made: list[tuple[Numbers, Floats, Numbers, Numbers]] = []
    amounts = np.array([offers[i].quantity for i in useful], dtype=np.int64)
    articles = np.array([offers[i].article for i in useful], dtype=np.int64)
    order = np.lexsort((offsets, parts))
    for part in np.unique(parts).tolist():
        first, last = np.searchsorted(parts[order], [part, part + 1])
        inside = order[first:last]
        length = float(grid.along.ravel()[part])
        if not np.isfinite(length):
            continue
        there = np.zeros((len(inside), len(asked)), dtype=np.int64)
        there[np.arange(len(inside)), articles[inside]] = amounts[inside]
        kinds, costs, pieces, cuts = _choices(length, offsets[inside], there, asked)
        made.append((PLAIN * part + kinds, costs, pieces, first + cuts))
    made.append(
        (
            np.empty(0, dtype=np.int64),
            np.empty(0),
            np.empty((0, len(asked)), dtype=np.int64),
            np.empty((0, 4), dtype=np.int64),
        )
    )
    groups, costs, pieces, cuts = (np.concatenate(field) for field in zip(*made, strict=True))
    filled = set(parts.tolist())
    return _network(
        grid,
        filled,
        Choices(groups, costs, pieces, cuts, np.array(useful, dtype=np.int64)[order]),
        asked,
    )


def _without_empty(grid: Grid, parts: npt.NDArray[np.intp]) -> tuple[Grid, npt.NDArray[np.intp]]:
    """Leave out columns without places, when everything is open: no tour needs them."""
    if not grid.is_open:
        return grid, parts
    blocks = grid.cross_aisles - 1
    kept = np.unique([*(parts // blocks), *(door.column for door in grid.doors)])
    sums = np.vstack([np.zeros((1, grid.cross_aisles)), np.cumsum(grid.across, axis=0)])
    column = np.searchsorted(kept, parts // blocks)
    smaller = Grid(
        across=np.diff(sums[kept], axis=0),
        along=grid.along[kept],
        doors=tuple(
            door._replace(column=int(np.searchsorted(kept, door.column))) for door in grid.doors
        ),
    )
    return smaller, column * blocks + parts % blocks


def _choices(
    length: float, offsets: Floats, amounts: Numbers, asked: Numbers
) -> tuple[Numbers, Floats, Numbers, Numbers]:
    """Return kinds, costs, pieces and cuts of the choices that no other one replaces."""
    places = np.unique(offsets)
    level = np.searchsorted(places, offsets)
    count = len(places)
    here = np.flatnonzero(amounts.any(axis=0))  # other articles cannot be told apart by
    there = np.zeros((count + 1, len(here)), dtype=np.int64)
    np.add.at(there[1:], level, amounts[:, here])
    first = np.cumsum(there, axis=0)  # pieces in the first so many places
    last = first[-1] - first  # and from each on
    out = np.append(0.0, 2 * places)
    back = np.append(2 * (length - places), 0.0)
    every, none = np.arange(1, count + 1), np.zeros(count, dtype=np.int64)
    reach, rest = _partly(first, last, asked[here])
    whole = np.array([count])
    ways = [
        ("pass", np.array([length]), whole, whole),
        ("twice", np.array([2 * length]), whole, whole),
        ("front", out[1:], every, none + count),
        ("back", back[:-1], none, every - 1),
        ("both", out[reach] + back[rest], reach, rest),
    ]
    kinds, costs, pieces, cuts = [], [], [], []
    for kind, *way in ways:
        order = np.argsort(way[0], kind="stable")
        cost, front, rear = (field[order] for field in way)
        total = np.minimum(first[front] + last[rear], asked[here])
        kept = _not_replaced(total)
        kinds.append(np.full(len(kept), KINDS.index(kind)))
        costs.append(cost[kept])
        pieces.append(total[kept])
        ends = np.searchsorted(level, [front[kept], rear[kept]])
        start = np.zeros_like(ends[0])
        cuts.append(np.column_stack([start, *ends, start + len(level)]))
    amount = np.concatenate(pieces)
    wide = np.zeros((len(amount), len(asked)), dtype=np.int64)
    wide[:, here] = amount
    return np.concatenate(kinds), np.concatenate(costs), wide, np.concatenate(cuts)


def _partly(first: Numbers, last: Numbers, asked: Numbers) -> tuple[Numbers, Numbers]:
    """Return how many places from the front and from which on, when both ends are entered.

    Something between is left out or nothing is; neither end goes one place on for nothing.
    """
    count = len(first) - 1
    reach, rest = np.triu_indices(count)
    reach = reach + 1  # from 1 on
    rest = rest.copy()
    use = rest >= reach
    reach, rest = reach[use], rest[use]
    total = np.minimum(first[reach] + last[rest], asked)
    shorter = np.minimum(first[reach - 1] + last[rest], asked)
    later = np.minimum(first[reach] + last[np.minimum(rest + 1, count)], asked)
    idle = (reach > 1) & (shorter == total).all(axis=1)
    idle |= (rest < count - 1) & (later == total).all(axis=1)
    return reach[~idle], rest[~idle]


def _not_replaced(total: Numbers) -> Numbers:
    """Return which rows have more of something than each one before."""
    kept = np.empty(0, dtype=np.int64)
    for begin in range(0, len(total), CHUNK):
        chunk = np.arange(begin, min(begin + CHUNK, len(total)))
        before = np.concatenate([kept, chunk])
        replaced = before[:, None] < chunk
        for article in range(total.shape[1]):
            replaced &= total[before, article][:, None] >= total[chunk, article]
        kept = np.concatenate([kept, chunk[~replaced.any(axis=0)]])
    return kept


@cache
def _across(cross_aisles: int, ends: Ends) -> Numbers:
    """Return the steps to the next column: state before, state after, walks of each segment."""
    flat = flatten(cross_aisles, ends)
    steps = {(s, s): [0] * cross_aisles for s in range(flat.count)}
    for cross in range(cross_aisles):
        group = cross_aisles - 1 + cross
        out: dict[int, list[tuple[int, int]]] = {}
        for before, after, walks in flat.steps[
            flat.starts[group] : flat.starts[group + 1]
        ].tolist():
            out.setdefault(before, []).append((after, walks))
        steps = {
            (first, after): [*done[:cross], walks, *done[cross + 1 :]]
            for (first, middle), done in steps.items()
            for after, walks in out.get(middle, ())
        }
    return np.array([[*pair, *walks] for pair, walks in steps.items()], dtype=np.int64)


def _layers(grid: Grid, filled: set[int]) -> list[tuple[Numbers, Floats, Numbers]]:
    """Return states before and after, costs and groups of all steps, layer by layer."""
    flat = flatten(grid.cross_aisles, grid.ends)
    blocks = grid.cross_aisles - 1
    across = _across(grid.cross_aisles, grid.ends)
    layers: list[tuple[Numbers, Floats, Numbers]] = []

    def steps_of(group: int) -> Numbers:
        return flat.steps[flat.starts[group] : flat.starts[group + 1]]

    for column in range(len(grid.along)):
        for door in grid.doors:
            if door.column == column:
                steps = steps_of(2 * blocks + 1 + door.cross)
                prices = steps[:, 2] * np.float64(door.length)
                layers.append((steps[:, :2], prices, np.full(len(steps), -1)))
        for block in range(blocks):
            part = column * blocks + block
            steps = steps_of(block)
            kinds = steps[:, 2]
            length = grid.along[column, block]
            if part in filled:
                group = np.where(kinds > 0, PLAIN * part + kinds, -1)
                prices = np.where(np.isfinite(length) | (kinds == 0), 0.0, np.inf)
            else:
                group = np.full(len(steps), -1)
                prices = np.array([0.0, length, 2 * length, np.inf, np.inf, np.inf])[kinds]
            layers.append((steps[:, :2], prices, group))
        last = column == len(grid.along) - 1
        lengths = np.full(blocks + 1, np.inf) if last else grid.across[column]
        with np.errstate(invalid="ignore"):
            each = np.where(across[:, 2:] > 0, across[:, 2:] * lengths, 0.0)
        layers.append((across[:, :2], each.sum(axis=1), np.full(len(across), -1)))
    return layers


def _network(grid: Grid, filled: set[int], choices: Choices, asked: Numbers) -> Network:
    """Return the arcs between states, column by column, that lie on a path."""
    table = flatten(grid.cross_aisles, grid.ends)
    layers = _layers(grid, filled)
    offered = set(choices.groups.tolist())
    reached = np.zeros(table.count, dtype=bool)
    reached[table.begin] = True
    kept = []
    for ends, prices, group in layers:
        use = reached[ends[:, 0]] & np.isfinite(prices)
        use &= np.array([g < 0 or g in offered for g in group.tolist()])
        kept.append((ends[use], prices[use], group[use]))
        reached = np.zeros(table.count, dtype=bool)
        reached[ends[use, 1]] = True
    wanted = np.zeros(table.count, dtype=bool)
    wanted[table.done] = True
    tails, heads, costs, groups = [], [], [], []
    for layer in range(len(kept) - 1, -1, -1):
        ends, prices, group = kept[layer]
        use = wanted[ends[:, 1]]
        tails.append(ends[use, 0] + layer * table.count)
        heads.append(ends[use, 1] + (layer + 1) * table.count)
        costs.append(prices[use])
        groups.append(group[use])
        wanted = np.zeros(table.count, dtype=bool)
        wanted[ends[use, 0]] = True
    tail, head = np.concatenate(tails[::-1]), np.concatenate(heads[::-1])
    names, where = np.unique(np.concatenate([tail, head]), return_inverse=True)
    order = np.argsort(where[len(tail) :], kind="stable")
    return Network(
        nodes=len(names),
        tails=where[: len(tail)][order],
        heads=where[len(tail) :][order],
        costs=np.concatenate(costs[::-1])[order],
        groups=np.concatenate(groups[::-1])[order],
        choices=choices,
        demand=asked,
    )


def step_of(warehouse: AisleWarehouse) -> float:
    """Return a length of which every tour is a multiple.

    A closed walk crosses every line an even number of times, and takes a single way to the depot
    twice.
    """
    lengths = [warehouse.aisle_pitch, warehouse.slot_pitch]
    lengths += [length for _, length in warehouse.doors]
    lengths += [gap for pair in warehouse.gaps for gap in pair]
    parts = [Fraction(str(length)) for length in lengths if length > 0.0]
    below = lcm(*(part.denominator for part in parts))
    times = 2.0 if len(warehouse.doors) == 1 else 1.0
    return times * gcd(*(int(part * below) for part in parts)) / below
