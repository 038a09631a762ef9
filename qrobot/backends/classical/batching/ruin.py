"""Ruin and recreate: remove orders that lie together, put them back at the least cost.

After Christiaens and Vanden Berghe (2020), "Slack induction by string removals", with
whole orders in the place of customers. An order that fits nowhere stays out and costs more
than any way; so the same search repairs broken plans and packs tight loads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot.backends.base import Stop
from qrobot.backends.classical.batching.tour import improve_tour, tour_length
from qrobot.backends.classical.whole import usual_distance
from qrobot.problem import Instance

__all__ = ["Batches", "SearchData"]

AVERAGE_REMOVED = 8
BLINK = 0.02
MEMO_SIZE = 50_000

FAR = 10.0
"""Ways this many times as long as usual say nothing about the differences between plans."""


class SearchData:
    """The instance in the numbers that the search works with.

    Stops are nodes 1..S of a matrix whose node 0 is the depot; orders own stops.
    """

    def __init__(self, instance: Instance, seed: int, stop: Stop) -> None:
        self.instance = instance
        self.stop = stop
        self.distances = instance.stop_distances
        self.capacities = instance.vehicle_capacities.tolist()
        self.weights = instance.order_weights.tolist()
        self.rng = np.random.default_rng(seed)
        self.order_of = [-1, *(int(instance.order_of_node[s[0]]) for s in instance.stops)]
        self.order_stops: list[list[int]] = [[] for _ in instance.orders]
        for node, order in enumerate(self.order_of):
            if node:
                self.order_stops[order].append(node)
        self.lost = 1.0 + 4.0 * float(self.distances.max(initial=1.0)) * len(self.distances)
        self.tie = 1e-12 * float(self.distances.max(initial=0.0))
        self.near = self._neighbours()
        self._memo: dict[frozenset[int], list[int]] = {}

    def _neighbours(self) -> npt.NDArray[np.intp]:
        """Return for each order the others, nearest first (least distance of two stops)."""
        both = np.minimum(self.distances, self.distances.T)[1:, 1:]
        owner = np.array(self.order_of[1:], dtype=np.intp)
        starts = np.flatnonzero(np.diff(owner, prepend=-1))
        if len(owner) and (np.diff(owner) < 0).any():
            raise AssertionError("stops are grouped by order")
        if not len(owner):
            return np.zeros((0, 0), dtype=np.intp)
        between = np.minimum.reduceat(np.minimum.reduceat(both, starts, axis=0), starts, axis=1)
        np.fill_diagonal(between, -1.0)
        return np.argsort(between, axis=1, kind="stable")

    def improved(self, tour: list[int]) -> list[int]:
        """Return a short tour past the same stops; remembered."""
        key = frozenset(tour)
        known = self._memo.get(key)
        if known is None or tour_length(self.distances, tour) < (
            tour_length(self.distances, known) * (1 - 1e-12)
        ):
            known = improve_tour(self.distances, tour, self.stop)
            if len(self._memo) >= MEMO_SIZE:
                self._memo.clear()
            self._memo[key] = known
        return known

    def driven(self, tours: list[list[int]]) -> float:
        """Return the length of tours without ways that are useless or lead far off."""
        nodes = np.array([0, *(s for tour in tours for s in (*tour, 0))], dtype=np.intp)
        legs = self.distances[nodes[:-1], nodes[1:]]
        most = min(self.instance.longest_useful, FAR * usual_distance(self.instance))
        return float(legs.sum(where=legs < most))

    def routes(self, tours: list[list[int]]) -> list[list[int]]:
        """Return tours of stops as routes of the instance's nodes."""
        stops = self.instance.stops
        return [[node for s in tour for node in stops[s - 1]] for tour in tours if tour]

    def tours(self, routes: list[list[int]]) -> list[list[int]]:
        """Return routes of the instance's nodes as tours of stops."""
        stop_of = {v: s + 1 for s, nodes in enumerate(self.instance.stops) for v in nodes}
        return [list(dict.fromkeys(stop_of[v] for v in route)) for route in routes]


@dataclass(slots=True)
class Batches:
    """A state of the search: one tour for each possible trip, and the orders left out.

    Parameters
    ----------
    data
        The instance.
    tours
        Stops of each possible trip in sequence; trip k has the k-th largest capacity.
    loads, lengths
        Of each trip.
    absent
        Orders that are on no trip.
    """

    data: SearchData
    tours: list[list[int]]
    loads: list[int]
    lengths: list[float]
    absent: list[int]

    @classmethod
    def empty(cls, data: SearchData) -> Batches:
        """Return the state in which nothing is collected yet."""
        trips = len(data.capacities)
        return cls(
            data,
            [[] for _ in range(trips)],
            [0] * trips,
            [0.0] * trips,
            [*range(len(data.weights))],
        )

    def copy(self) -> Batches:
        """Return a state that can be changed without changing this one."""
        return Batches(
            self.data, self.tours.copy(), self.loads.copy(), self.lengths.copy(), self.absent.copy()
        )

    @property
    def cost(self) -> float:
        """Distance, with a price on trips (ties) and a very high one on absent orders."""
        used = sum(1 for tour in self.tours if tour)
        out = sum(self.data.weights[o] + 1 for o in self.absent)
        return float(sum(self.lengths) + self.data.tie * used + self.data.lost * out)

    def put(self, trip: int, tour: list[int]) -> None:
        """Set a trip's tour and its length."""
        self.tours[trip] = tour
        self.lengths[trip] = tour_length(self.data.distances, tour)

    def remove(self, order: int) -> None:
        """Take an order off its trip."""
        stops = set(self.data.order_stops[order])
        for trip, tour in enumerate(self.tours):
            if not stops.isdisjoint(tour):
                self.put(trip, [s for s in tour if s not in stops])
                self.loads[trip] -= self.data.weights[order]
                break
        self.absent.append(order)

    def ruin(self) -> set[int]:
        """Remove orders near a random one, in runs along their trips; return the trips."""
        data, rng = self.data, self.data.rng
        count = len(data.weights)
        filled = sum(1 for tour in self.tours if tour)
        longest = max(1.0, min(10.0, (count - len(self.absent)) / max(filled, 1)))
        strings = int(rng.uniform(1, 4 * AVERAGE_REMOVED / (1 + longest)))
        trip_of = {data.order_of[s]: t for t, tour in enumerate(self.tours) for s in tour}
        ruined: set[int] = set()
        for order in data.near[int(rng.integers(count))].tolist():
            trip = trip_of.get(order)
            if trip is None or trip in ruined:
                continue
            line = list(dict.fromkeys(data.order_of[s] for s in self.tours[trip]))
            size = int(rng.uniform(1, min(len(line), longest) + 1))
            at = line.index(order)
            first = int(rng.integers(max(0, at - size + 1), min(at, len(line) - size) + 1))
            for gone in line[first : first + size]:
                self.remove(gone)
            ruined.add(trip)
            if len(ruined) >= strings:
                break
        return ruined

    def recreate(self) -> set[int]:
        """Put absent orders back, each where it costs least; return the changed trips."""
        data, rng = self.data, self.data.rng
        kind = rng.choice(4, p=[0.4, 0.35, 0.15, 0.1])
        weights, far = data.weights, data.distances[0]
        rng.shuffle(self.absent)
        if kind == 1:
            self.absent.sort(key=lambda o: -weights[o])
        elif kind == 2:
            self.absent.sort(key=lambda o: -far[data.order_stops[o]].max())
        elif kind == 3:
            self.absent.sort(key=lambda o: far[data.order_stops[o]].max())
        changed: set[int] = set()
        left: list[int] = []
        for order in self.absent:
            best, where, tour = np.inf, -1, []
            opened: set[int] = set()
            for trip, capacity in enumerate(data.capacities):
                if self.loads[trip] + weights[order] > capacity:
                    continue
                if not self.tours[trip]:
                    if capacity in opened:
                        continue  # an empty trip of this size was tried already
                    opened.add(capacity)
                cost, candidate = self._inserted(trip, order)
                if cost < best:
                    best, where, tour = cost, trip, candidate
            if where < 0:
                left.append(order)
                continue
            self.put(where, tour)
            self.loads[where] += weights[order]
            changed.add(where)
        self.absent = left
        return changed

    def _inserted(self, trip: int, order: int) -> tuple[float, list[int]]:
        """Return what it costs to add an order's stops one by one, and the tour then."""
        d, rng = self.data.distances, self.data.rng
        tour, total = self.tours[trip], 0.0
        for stop in self.data.order_stops[order]:
            before = np.array([0, *tour], dtype=np.intp)
            after = np.array([*tour, 0], dtype=np.intp)
            extra = d[before, stop] + d[stop, after] - d[before, after]
            if len(extra) > 1:
                extra = np.where(rng.random(len(extra)) < BLINK, np.inf, extra)
            at = int(np.argmin(extra))
            total += float(extra[at])
            tour = [*tour[:at], stop, *tour[at:]]
        return total, tour

    def polish(self, trips: set[int]) -> None:
        """Shorten the tours of some trips."""
        for trip in trips:
            self.put(trip, self.data.improved(self.tours[trip]))
