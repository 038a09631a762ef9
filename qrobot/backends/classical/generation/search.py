"""Column generation: proven batches of whole orders in an aisle warehouse, or a valid bound.

A set partition chooses batches. Its linear programme starts with few of them; its duals price the
rest, and the batches of negative reduced cost come in until there are none. What it costs then is
a lower bound. Cuts raise it, and batches whose reduced cost is larger than the gap to the best
plan are in no better plan. Then the question is split, by the number of trips or by two orders
that are together or apart, and each part is solved in the same way (branch, price and cut).

Where all batches that fit on a robot can be listed, they are, once (`MOST_BATCHES`); otherwise
each pricing searches them, and only those are listed that the gap leaves.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Stop
from qrobot.backends.classical.generation import batches
from qrobot.backends.classical.generation.batches import Pool, Prices, Work
from qrobot.backends.classical.generation.cuts import violated_cuts
from qrobot.backends.classical.generation.master import Master, Pairs
from qrobot.backends.classical.orders import Batch, Orders, lengths_of

__all__ = ["Generation", "Proof"]

Rows = npt.NDArray[np.intp]

MOST_BATCHES = 4_000_000
"""Batches that are listed: 100 to 200 MB."""

SEARCHED = 20_000
"""Batches that a search for negative reduced costs ends at."""

MOST_CUTS, CUTS_AT_ONCE, VIOLATION = 250, 25, 0.02
"""Cuts in all and at once, and by how much a cut must be violated."""

CANDIDATES = 6
"""Pairs of orders whose two parts are tried before one pair is chosen."""

TOLERANCE = 1e-7
"""Reduced costs this much below 0, as a share of a mean batch, are rounding."""

MOST_COLUMNS = 12_000
"""Batches in the linear programme; beyond that it is made anew from those that matter."""


@dataclass(slots=True)
class Proof:
    """What is known.

    Parameters
    ----------
    bound
        Every plan costs at least this: metres, with the price of trips.
    plan
        The orders of each batch of a plan that costs less than the one given; None without.
    complete
        Whether the plan found, or the one given, is proven to be best.
    programmes, work
        Linear programmes solved, and units of work done.
    """

    bound: float = 0.0
    plan: list[Batch] | None = None
    complete: bool = False
    programmes: int = 0
    work: int = 0


@dataclass(slots=True)
class Part:
    """A part of the question.

    Parameters
    ----------
    bound
        No plan of this part costs less.
    trips
        Least and most trips.
    together, apart
        Pairs of orders that share a trip, and that do not.
    rows
        Batches of the pool that plans of this part may hold; None: not listed.
    estimate
        What the linear programme costs before all batches were priced: no bound.
    """

    bound: float
    trips: tuple[int, int]
    together: Pairs = ()
    apart: Pairs = ()
    rows: Rows | None = None
    estimate: float = 0.0


class Generation:
    """Bounds and proofs for one question.

    Parameters
    ----------
    orders
        The question.
    tie
        What each trip costs on top of its length, metres: plans differ by no less.
    """

    def __init__(self, orders: Orders, tie: float) -> None:
        self.orders, self.tie = orders, tie
        self.count = len(orders.weights)
        capacities = orders.capacities
        # Trips heavier than c need robots larger than c; that is enough, since the heaviest
        # trips go to the largest robots. Rows that cannot bind are left out.
        limits = np.unique(capacities)[:-1].tolist()
        fleet = [(limit, int((capacities > limit).sum())) for limit in limits]
        self.fleet = [(limit, most) for limit, most in fleet if most < self.count]
        fewest = int(np.searchsorted(np.cumsum(capacities), orders.weights.sum())) + 1
        self.trips = fewest, min(self.count, len(capacities))
        lightest = np.cumsum(np.sort(orders.weights))
        self.width = max(1, int(np.searchsorted(lightest, capacities[0], side="right")))
        self.narrow = np.int8 if self.count <= 127 else np.int16
        self.scale = float(orders.alone.mean())
        self.random = np.random.default_rng(0)
        self.pool: Pool | None = None
        self.proof = Proof()
        self.upper = math.inf
        self.master = self._new_master()
        self._add(self.pool_of([(order,) for order in range(self.count)]))

    def pool_of(self, plan: list[Batch]) -> Pool:
        """Return batches given by their orders."""
        members = np.full((len(plan), self.width), -1, dtype=self.narrow)
        for row, batch in enumerate(plan):
            members[row, : len(batch)] = sorted(batch)
        words = [np.bitwise_or.reduce(self.orders.masks[list(b)], axis=0) for b in plan]
        loads = [self.orders.weights[list(b)].sum() for b in plan]
        lengths = lengths_of(self.orders.layout, np.array(words))
        return Pool(members, lengths, np.array(loads, dtype=np.int64))

    def add(self, plan: list[Batch]) -> None:
        """Let batches that are known to be good take part from the start."""
        self._add(self.pool_of(plan))

    def prove(self, upper: float, until: Stop) -> Proof:
        """Prove that no plan costs less than a known one, find a better one, or a bound.

        Parameters
        ----------
        upper
            Cost of a known plan, with the price of trips; ``inf`` without one.
        until
            Deadline, interrupts and limit of work: linear programmes, and lists of batches.
        """
        stop = Work(until)
        proof = self.proof = Proof()
        # No plan costs more than a trip for each order.
        self.upper = min(upper, 2.0 * self.scale * self.count)
        if self.trips[0] > self.trips[1]:  # more trips are needed than there are
            proof.complete = True
            return proof
        self._list_all(stop)
        rows = None if self.pool is None else np.arange(len(self.pool.lengths))
        parts = [(0.0, 0, Part(0.0, self.trips, rows=rows))]
        made = 0
        while parts and not stop():
            proof.bound = max(proof.bound, min(parts[0][0], self.upper))
            if parts[0][0] > self.limit:
                parts = []
                break
            _, _, part = heapq.heappop(parts)
            smaller = self._split(part, stop, cutting=not made)
            if smaller is None:  # no time, or nothing to split
                heapq.heappush(parts, (part.bound, -1, part))
                break
            for piece in smaller:
                made += 1
                heapq.heappush(parts, (piece.bound, made, piece))
        proof.complete, proof.work = not parts, stop.done
        left = min((bound for bound, _, _ in parts), default=self.upper)
        proof.bound = min(max(proof.bound, left), self.upper)
        return proof

    def improve(self, members: Ints, upper: float, stop: Stop) -> list[Batch] | None:
        """Return the best plan of given batches that costs less than a known one, None without.

        Parameters
        ----------
        members
            Shape (batches, width): their orders, -1 after the last.
        upper
            Cost of the known plan, with the price of trips.
        stop
            Deadline and interrupts.
        """
        kept = members[(members >= 0).sum(axis=1) <= self.width]
        self.pool = self.pool_of([tuple(sorted(o for o in row if o >= 0)) for row in kept.tolist()])
        self.upper = upper
        return self.prove(upper, stop).plan

    @property
    def limit(self) -> float:
        """Better plans cost no more than this."""
        return self.upper - 0.5 * self.tie

    def _new_master(self) -> Master:
        outside = 10.0 * self.scale * self.count
        return Master(self.count, self.trips, self.fleet, outside)

    def _add(self, pool: Pool) -> int:
        return self.master.add(pool.members, pool.lengths + self.tie, pool.loads)

    def _list_all(self, stop: Work) -> None:
        """List every batch where they are few enough and none are given."""
        if self.pool is not None:
            return
        weights, most = self.orders.weights, int(self.orders.capacities[0])
        expected = batches.count_batches(weights, most)
        if expected <= MOST_BATCHES and not stop():
            free = self._prices(np.zeros(self.count), np.zeros(len(self.fleet)), np.zeros(0))
            pool, least = self._search(free, math.inf, int(expected) + 2, stop, expected)
            self.pool = pool if least > -math.inf else None

    def _search(
        self, prices: Prices, below: float, most: int, stop: Work, expected: float = 0.0
    ) -> tuple[Pool, float]:
        room = Pool(
            np.empty((most, self.width), dtype=self.narrow),
            np.empty(most),
            np.empty(most, dtype=np.int64),
        )
        return batches.find_batches(self.orders, prices, below, room, stop, expected)

    def _prices(self, of_orders: Floats, of_trips: Floats, of_cuts: Floats) -> Prices:
        of: list[list[tuple[int, int]]] = [[] for _ in range(self.count)]
        for at, cut in enumerate(self.master.cuts):
            if of_cuts[at] < 0.0:
                for order, multiplier in zip(cut.orders, cut.multipliers, strict=True):
                    of[order].append((at, multiplier))
        flat = [entry for entries in of for entry in entries]
        return Prices(
            orders=of_orders,
            loads=np.array([limit for limit, _ in self.fleet], dtype=np.int64),
            trips=of_trips,
            cuts=of_cuts,
            divisors=np.array([cut.divisor for cut in self.master.cuts], dtype=np.int64),
            cuts_of=np.array([at for at, _ in flat], dtype=np.int64),
            multipliers=np.array([multiplier for _, multiplier in flat], dtype=np.int64),
            first_cut=np.cumsum([0, *map(len, of)]).astype(np.int64),
        )

    def _split(self, part: Part, stop: Work, *, cutting: bool) -> list[Part] | None:
        """Solve a part; return what is left of it in parts, None without time."""
        if len(self.master) > MOST_COLUMNS:
            self._forget()
        self.master.restrict(part.trips, part.together, part.apart)
        while True:
            if not self._converge(part, stop):
                return [] if part.bound > self.limit else None
            self._note_plan()
            if part.bound > self.limit:
                return []
            if not (cutting and len(self.master.cuts) < MOST_CUTS and self._cut()):
                break
        if part.rows is None:
            self._list_gap(part, stop)
            if part.rows is None:
                return None
        return self._branch(part)

    def _converge(self, part: Part, stop: Work) -> bool:
        """Solve the linear programme over all batches of a part; return whether it is solved."""
        pool = None
        if part.rows is not None and self.pool is not None:
            pool = self.pool.take(part.rows)
        while not stop():
            value = self.master.solve()
            self.proof.programmes += 1
            stop.done += 1
            prices = self._prices(*self.master.prices)
            offset = self.tie - self.master.trip_price
            if pool is None:
                found, least = self._search(
                    prices, -offset - TOLERANCE * self.scale, SEARCHED, stop
                )
                reduced = batches.reduced_costs(found, prices) + offset
                least = min(0.0, least + offset)
            else:
                found, reduced = pool, batches.reduced_costs(pool, prices) + offset
                least = float(reduced.min(initial=0.0))
            # A plan of so many trips costs at most so much less than the programme.
            bound = value + part.trips[1] * min(0.0, least)
            part.bound = max(part.bound, bound)
            if part.bound > self.limit:
                return True
            if pool is not None and part.rows is not None:
                kept = bound + (reduced - least) <= self.limit + TOLERANCE * self.scale
                if kept.mean() < 0.8:
                    part.rows, pool = part.rows[kept], pool.take(kept)
                    found, reduced = pool, reduced[kept]
            if least >= -TOLERANCE * self.scale:
                return True
            rows = batches.best_for_each(found.members, reduced, self.count)
            if not self._add(found.take(rows)):
                return True
        return False

    def _note_plan(self) -> None:
        """Keep the plan of a linear programme whose batches are whole."""
        used, shares = self.master.used()
        whole = bool((shares > 1.0 - 1e-6).all())
        if whole and sorted(o for batch in used for o in batch) == list(range(self.count)):
            cost = float((self.pool_of(used).lengths + self.tie).sum())
            if cost <= self.limit:
                self.upper, self.proof.plan = cost, used

    def _list_gap(self, part: Part, stop: Work) -> None:
        """List the batches that a better plan may hold, where they are few enough."""
        if stop() or not math.isfinite(self.upper):
            return
        prices = self._prices(*self.master.prices)
        below = self.limit - part.bound - self.tie + self.master.trip_price
        pool, least = self._search(prices, below, MOST_BATCHES, stop)
        if least > -math.inf:
            self.pool, part.rows = pool, np.arange(len(pool.lengths))

    def _cut(self) -> bool:
        """Add the most violated cuts; return whether there were any."""
        used, shares = self.master.used()
        found = violated_cuts(
            used, shares, self.count, CUTS_AT_ONCE, VIOLATION, set(self.master.cuts), self.random
        )
        self.master.cut(found)
        return bool(found)

    def _branch(self, part: Part) -> list[Part]:
        """Return two parts that leave the present fractions out."""
        used, shares = self.master.used()
        trips = float(shares.sum())
        low, high = part.trips
        if abs(trips - round(trips)) > 1e-4:
            below = math.floor(trips)
            return [
                self._piece(part, trips=(low, below)),
                self._piece(part, trips=(below + 1, high)),
            ]
        share: dict[tuple[int, int], float] = {}
        for batch, value in zip(used, shares.tolist(), strict=True):
            for k, j in enumerate(batch):
                for i in batch[:k]:
                    share[i, j] = share.get((i, j), 0.0) + value
        fraction = {pair: min(v, 1.0 - v) for pair, v in share.items() if 1e-4 < v < 1 - 1e-4}
        if not fraction:
            return []  # the plan was noted: its cost is the bound of this part
        likely = sorted(fraction, key=lambda pair: -fraction[pair])[:CANDIDATES]
        return max((self._pieces(part, pair) for pair in likely), key=_gain)

    def _pieces(self, part: Part, pair: tuple[int, int]) -> list[Part]:
        """Return the parts with two orders together and apart, with an estimate of each."""
        pieces = [
            self._piece(part, together=(*part.together, pair)),
            self._piece(part, apart=(*part.apart, pair)),
        ]
        for piece in pieces:
            self.master.restrict(piece.trips, piece.together, piece.apart)
            piece.estimate = self.master.solve()
            self.proof.programmes += 1
        return pieces

    def _piece(self, part: Part, **limits: Any) -> Part:
        """Return a part of a part."""
        piece = replace(part, **limits, estimate=0.0)
        assert self.pool is not None
        assert part.rows is not None
        members = self.pool.members[part.rows]
        kept = np.ones(len(members), dtype=bool)
        for pairs, both in ((piece.together, True), (piece.apart, False)):
            for i, j in pairs[-1:]:  # the others were left out before
                one, other = (members == i).any(axis=1), (members == j).any(axis=1)
                kept &= one == other if both else ~(one & other)
        piece.rows = part.rows[kept]
        return piece

    def _forget(self) -> None:
        """Make the linear programme anew from the batches that matter."""
        old = self.master
        self.master = self._new_master()
        self.master.cut(old.cuts)
        members, costs, loads = old.cheapest(MOST_COLUMNS // 4, self.width)
        self.master.add(members, costs, loads)


def _gain(pieces: list[Part]) -> float:
    """Return how much a split raises both estimates, as their product."""
    return math.prod(max(piece.estimate - piece.bound, 1e-3) for piece in pieces)
