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
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Stop
from qrobot.backends.classical.generation import batches
from qrobot.backends.classical.generation.batches import Pool, Prices, Work
from qrobot.backends.classical.generation.cuts import violated_cuts
from qrobot.backends.classical.generation.master import Master
from qrobot.backends.classical.generation.parts import Part, Proof, gain
from qrobot.backends.classical.orders import Batch, Orders, lengths_of

__all__ = ["Generation"]

Seek = Callable[[Stop], list[Batch]]

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
        self.proof = Proof()
        self.upper, self.best_trips = math.inf, self.count
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

    def prove(
        self,
        known: list[Batch] | None,
        until: Stop,
        seek: Seek | None = None,
        given: Pool | None = None,
    ) -> Proof:
        """Prove that no plan costs less than a known one, find a better one, or a bound.

        Parameters
        ----------
        known
            A plan to compare with.
        until
            Deadline, interrupts and limit of work: linear programmes, and lists of batches.
        seek
            Asked for another plan now and then: a better one makes every part smaller.
        given
            The batches to choose from; by default all.
        """
        stop = Work(until)
        proof = self.proof = Proof()
        self.upper, self.best_trips = 2.0 * self.orders.most, self.count
        self._offer(known)
        proof.plan = None
        if self.trips[0] > self.trips[1]:  # more trips are needed than there are
            proof.complete = True
            return proof
        number = count()  # breaks ties between parts of one bound
        parts = [(0.0, next(number), part) for part in self._first_parts(given)]
        while parts and not stop():
            proof.bound = max(proof.bound, min(parts[0][0], self.upper))
            if parts[0][0] > self.limit:
                parts = []
                break
            _, _, part = heapq.heappop(parts)
            smaller = self._split(part, stop)
            if smaller is None:  # no time, or nothing to split
                heapq.heappush(parts, (part.bound, next(number), part))
                break
            for piece in smaller:
                heapq.heappush(parts, (piece.bound, next(number), piece))
            if seek is not None and parts:
                self._offer(seek(stop))
        proof.complete, proof.work = not parts, stop.done
        left = min((bound for bound, _, _ in parts), default=self.upper)
        proof.bound = min(max(proof.bound, left), self.upper)
        return proof

    def improve(self, members: Ints, known: list[Batch], stop: Stop) -> list[Batch] | None:
        """Return the best plan of given batches that costs less than a known one, None without.

        Parameters
        ----------
        members
            Shape (batches, width): their orders, -1 after the last.
        known
            A plan to compare with.
        stop
            Deadline and interrupts.
        """
        kept = members[(members >= 0).sum(axis=1) <= self.width]
        given = self.pool_of([tuple(sorted(o for o in row if o >= 0)) for row in kept.tolist()])
        return self.prove(known, stop, given=given).plan

    @property
    def limit(self) -> float:
        """Better plans cost no more than this: with as few trips as can be, they are shorter."""
        fewest = self.best_trips == self.trips[0]
        return self.upper - self.tie * (self.count + 1 if fewest else 0.5)

    def _offer(self, plan: list[Batch] | None) -> None:
        """Keep a plan if it is the best."""
        if not plan:
            return
        pool = self.pool_of(plan)
        self._add(pool)
        cost = float((pool.lengths + self.tie).sum())
        if cost <= self.limit:
            self.upper, self.best_trips, self.proof.plan = cost, len(plan), plan

    def _new_master(self) -> Master:
        outside = 10.0 * self.orders.most
        return Master(self.count, self.trips, self.fleet, outside)

    def _add(self, pool: Pool) -> int:
        return self.master.add(pool.members, pool.lengths + self.tie, pool.loads)

    def _first_parts(self, given: Pool | None) -> list[Part]:
        """Return the question by its number of trips.

        With as few trips as can be, every trip is nearly full: that leaves few batches.
        """
        fewest, most = self.trips
        ranges = [(fewest, fewest), (fewest + 1, most)] if fewest < most else [self.trips]
        rows = None if given is None else np.arange(len(given.lengths))
        return [self._piece(Part(0.0, self.trips, pool=given, rows=rows), trips=r) for r in ranges]

    def _list_all(self, part: Part, stop: Work) -> None:
        """List every batch of a part where they are few enough."""
        weights, most = self.orders.weights, int(self.orders.capacities[0])
        expected = batches.count_batches(weights, most, self._lightest(part.trips[1]))
        if expected > MOST_BATCHES or stop():
            return
        no_cuts = np.zeros(len(self.master.cuts))
        free = self._prices(np.zeros(self.count), np.zeros(len(self.fleet)), no_cuts)
        room = int(1.1 * expected) + 100  # coarse units of weight let a few more fit
        pool, least = self._search(free, math.inf, part.trips[1], room, stop, expected)
        if least > -math.inf:
            part.pool, part.rows = pool, np.arange(len(pool.lengths))

    def _lightest(self, most_trips: int) -> int:
        """Return the least load of a trip: the others cannot hold more than they take."""
        others = int(self.orders.capacities[: most_trips - 1].sum())
        return max(0, int(self.orders.weights.sum()) - others)

    def _restrict(self, part: Part) -> None:
        lightest = self._lightest(part.trips[1])
        self.master.restrict(part.trips, lightest, part.together, part.apart)

    def _search(
        self,
        prices: Prices,
        below: float,
        trips: int,
        most: int,
        stop: Work,
        expected: float = 0.0,
    ) -> tuple[Pool, float]:
        room = Pool(
            np.empty((most, self.width), dtype=self.narrow),
            np.empty(most),
            np.empty(most, dtype=np.int64),
        )
        return batches.find_batches(
            self.orders, prices, below, self._lightest(trips), room, stop, expected
        )

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

    def _split(self, part: Part, stop: Work) -> list[Part] | None:
        """Solve a part; return what is left of it in parts, None without time."""
        if len(self.master) > MOST_COLUMNS:
            self._forget()
        self._restrict(part)
        whole = not (part.together or part.apart)
        if whole and not part.started:  # every part gets a bound before one gets cuts
            if part.pool is None:
                self._list_all(part, stop)
            part.started = self._converge(part, stop)
            if not part.started:
                return None
            return [] if part.bound > self.limit else [part]
        while True:
            if not self._converge(part, stop):
                return [] if part.bound > self.limit else None
            self._note_plan()
            if part.bound > self.limit:
                return []
            if not (whole and len(self.master.cuts) < MOST_CUTS and self._cut()):
                break
        if part.rows is None:
            self._list_gap(part, stop)
            if part.rows is None:
                return None
        return self._branch(part)

    def _converge(self, part: Part, stop: Work) -> bool:
        """Solve the linear programme over all batches of a part; return whether it is solved."""
        pool = None
        if part.rows is not None and part.pool is not None:
            pool = part.pool.take(part.rows)
        while not stop():
            value = self.master.solve()
            self.proof.programmes += 1
            stop.done += 1
            prices = self._prices(*self.master.prices)
            offset = self.tie - self.master.trip_price
            if pool is None:
                found, least = self._search(
                    prices, -offset - TOLERANCE * self.scale, part.trips[1], SEARCHED, stop
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
                if kept.sum() < 0.8 * len(kept):
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
            self._offer(used)

    def _list_gap(self, part: Part, stop: Work) -> None:
        """List the batches that a better plan may hold, where they are few enough."""
        if stop() or not math.isfinite(self.upper):
            return
        prices = self._prices(*self.master.prices)
        below = self.limit - part.bound - self.tie + self.master.trip_price
        pool, least = self._search(prices, below, part.trips[1], MOST_BATCHES, stop)
        if least > -math.inf:
            part.pool, part.rows = pool, np.arange(len(pool.lengths))

    def _cut(self) -> bool:
        """Add the most violated cuts; return whether there were any."""
        used, shares = self.master.used()
        found = violated_cuts(
            used, shares, self.count, CUTS_AT_ONCE, VIOLATION, set(self.master.cuts), self.random
        )
        self.master.cut(found)
        return bool(found)

    def _branch(self, part: Part) -> list[Part] | None:
        """Return two parts that leave the present fractions out; None when there are none."""
        used, shares = self.master.used()
        trips = float(shares.sum())
        low, high = part.trips
        if low < high and abs(trips - round(trips)) > 1e-4:
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
            return None
        likely = sorted(fraction, key=lambda pair: -fraction[pair])[:CANDIDATES]
        return max((self._pieces(part, pair) for pair in likely), key=gain)

    def _pieces(self, part: Part, pair: tuple[int, int]) -> list[Part]:
        """Return the parts with two orders together and apart, with an estimate of each."""
        pieces = [
            self._piece(part, together=(*part.together, pair)),
            self._piece(part, apart=(*part.apart, pair)),
        ]
        for piece in pieces:
            self._restrict(piece)
            piece.estimate = self.master.solve()
            self.proof.programmes += 1
        return pieces

    def _piece(self, part: Part, **limits: Any) -> Part:
        """Return a part of a part."""
        piece = replace(part, **limits, estimate=0.0)
        if part.pool is None or part.rows is None:
            return piece
        members = part.pool.members[part.rows]
        kept = part.pool.loads[part.rows] >= self._lightest(piece.trips[1])
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
