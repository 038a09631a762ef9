"""Which orders of a pool are planned together: in one place, due at one time, or of one zone."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot.errors import InfeasibleError, InputError
from qrobot.planning.feasibility import reason_infeasible
from qrobot.problem import MAX_STOPS, Instance, Place, Slot

__all__ = ["WAYS", "cut"]

Orders = npt.NDArray[np.intp]
"""Indices of orders."""

WAYS = ("size", "due", "zone")
"""What waves may be cut by."""

_RANGE = re.compile(r"([0-9]{1,6})(?:-([0-9]{1,6}))?")


def cut(
    pool: Instance, *, by: str = "size", size: int = MAX_STOPS, zones: str = "blocks"
) -> tuple[tuple[int, ...], ...]:
    """Return the orders (their indices) of each wave; every order is in one.

    No wave has more than `size` stops, and the robots' trips have room for each: its orders
    fit by first fit, the heaviest first. Neighbouring are, in aisles, orders with the same last
    aisle: together they leave out what lies behind it. Elsewhere it is the direction of the
    place that is farthest from the depot (the sweep of Gillett and Miller 1974).

    Parameters
    ----------
    pool
        The orders; their number does not matter.
    by
        ``size``: neighbouring orders together, in waves of about the same size. ``due``: what
        is due first comes first, as much as a wave may have; orders of one due time are parted
        only where they are too many. ``zone``: an order is in the zone where most of its items lie.
    size
        Most stops (places of each order) of a wave.
    zones
        Of ``zone``, in aisle warehouses: ``blocks``, or ranges of aisles such as ``0-4,5-9``.

    Raises
    ------
    InputError
        When an argument cannot be used.
    InfeasibleError
        When an order fits on no robot.
    """
    if by not in WAYS:
        raise InputError(
            f"{by!r} is no way to cut", field="by", advice=f"use one of: {', '.join(WAYS)}"
        )
    if not 1 <= size <= MAX_STOPS:
        raise InputError(
            f"{size} is not 1 to {MAX_STOPS} stops", field="size", advice="use such a number"
        )
    cutter = _Cutter(pool, size)
    everything = np.arange(len(pool.orders))
    if not len(everything):
        return ()
    if by == "due":
        waves = cutter.by_due(everything)
    elif by == "zone":
        waves = [wave for zone in _in_zones(pool, zones) for wave in cutter.parts(zone)]
    else:
        waves = cutter.parts(everything)
    return tuple(tuple(sorted(wave.tolist())) for wave in waves)


class _Cutter:
    """Cuts orders into parts that a plan may have."""

    def __init__(self, pool: Instance, size: int) -> None:
        self.pool, self.size = pool, size
        self.stops = _stops_of_orders(pool)
        self.weights = pool.order_weights
        self.rooms = pool.vehicle_capacities
        self.shares = np.maximum(self.stops / size, self.weights / max(1, int(self.rooms.sum())))
        self.rank = _ranks(pool)

    def parts(self, orders: Orders) -> list[Orders]:
        """Return neighbouring orders together: in parts of like size where these fit."""
        orders = orders[np.argsort(self.rank[orders], kind="stable")]
        filled: list[Orders] = []
        left = orders
        while len(left):
            first = self._most(left)
            filled.append(left[:first])
            left = left[first:]
        # As many parts, but the last one no smaller than the others.
        reach = np.cumsum(self.shares[orders])
        ends = np.searchsorted(reach, reach[-1] * np.arange(1, len(filled)) / len(filled))
        even = np.split(orders, ends + 1)
        return even if all(len(part) and self.fits(part) for part in even) else filled

    def _most(self, orders: Orders) -> int:
        """Return how many of the first orders are one wave."""
        if not self.fits(orders[:1]):
            raise self._too_large(int(orders[0]))
        fits, fails = 1, 2
        while fails <= len(orders) and self.fits(orders[:fails]):
            fits, fails = fails, 2 * fails
        fails = min(fails, len(orders) + 1)
        while fails - fits > 1:
            middle = (fits + fails) // 2
            fits, fails = (middle, fails) if self.fits(orders[:middle]) else (fits, middle)
        return fits

    def by_due(self, orders: Orders) -> list[Orders]:
        """Return orders by their due times, as many in each part as it may have."""
        due = np.array([self.pool.orders[o].due for o in orders])
        groups = [orders[due == time] for time in np.unique(due)]
        found: list[Orders] = []
        for group in groups:
            joined = np.concatenate([found[-1], group]) if found else group
            if self.fits(joined):
                found[-1:] = [joined]
            else:
                found += self.parts(group)
        return found

    def fits(self, orders: Orders) -> bool:
        """Return whether orders are one wave: not too many stops, room on the robots' trips."""
        if int(self.stops[orders].sum()) > self.size:
            return False
        weights = np.sort(self.weights[orders])[::-1]
        room = self.rooms[: len(weights)].copy()
        for weight in weights:
            has_room = room >= weight
            first = int(has_room.argmax())
            if not has_room[first]:
                return False
            room[first] -= weight
        return True

    def _too_large(self, order: int) -> InputError | InfeasibleError:
        one = self.pool.orders[order]
        if self.stops[order] > self.size:
            return InputError(
                f"order {one.id!r} alone has {self.stops[order]} stops, more than the "
                f"{self.size} of a wave",
                field="size",
                advice="give more"
                if self.stops[order] <= MAX_STOPS
                else "part the order (--split-orders)",
            )
        return InfeasibleError(reason_infeasible(self.pool) or f"order {one.id!r} fits no robot")


def _stops_of_orders(pool: Instance) -> npt.NDArray[np.int64]:
    """Return for each order in how many places its items lie."""
    return np.array(
        [len({pool.items[v - 1].place for v in nodes}) for nodes in pool.order_nodes],
        dtype=np.int64,
    )


def _ranks(pool: Instance) -> npt.NDArray[np.int64]:
    """Return for each order its rank in a sequence of neighbours."""
    places = [[pool.items[v - 1].place for v in nodes] for nodes in pool.order_nodes]
    if all(isinstance(place, Slot) for own in places for place in own):
        aisles = [[p.aisle for p in own if isinstance(p, Slot)] for own in places]
        keys = [(float(max(own)), float(np.mean(own))) for own in aisles]
    else:
        where, (x, y) = _in_plane(pool)
        keys = []
        for own in places:
            ways = [(where(p)[0] - x, where(p)[1] - y) for p in own]
            far = max(ways, key=lambda way: math.hypot(*way))
            keys.append((math.atan2(far[1], far[0]), math.hypot(*far)))
    ranks = np.empty(len(keys), dtype=np.int64)
    ranks[sorted(range(len(keys)), key=keys.__getitem__)] = np.arange(len(keys))
    return ranks


def _in_plane(
    pool: Instance,
) -> tuple[Callable[[Place], tuple[float, float]], tuple[float, float]]:
    """Return what gives the position of a place, and that of the depot.

    Where people measured ways and not positions: how far it is from the depot, and from what
    lies farthest from the depot.
    """
    house = pool.warehouse
    if not house.has_given_distances:
        return house.position, house.depot
    d = np.minimum(ways := house.distance_matrix(pool.places), ways.T)
    away = np.where(np.isfinite(d[0]), d[0], 0.0)
    other = d[int(away.argmax())]
    far = np.where(np.isfinite(other), other, 0.0)
    rows = pool.row_of_place
    return lambda place: (float(away[rows[place]]), float(far[rows[place]])), (0.0, float(far[0]))


def _in_zones(pool: Instance, zones: str) -> list[Orders]:
    """Return the orders of each zone that has some."""
    zone_of = _zone_of(pool, zones)
    homes = np.array(
        [
            Counter(zone_of(pool.items[v - 1].place) for v in nodes).most_common(1)[0][0]
            for nodes in pool.order_nodes
        ]
    )
    return [np.flatnonzero(homes == zone) for zone in np.unique(homes)]


def _zone_of(pool: Instance, zones: str) -> Callable[[Place], int]:
    if not all(isinstance(item.place, Slot) for item in pool.items):
        raise InputError(
            "zones are blocks or aisles, which this warehouse has not",
            field="by",
            advice="cut by size",
        )
    if zones == "blocks":
        return lambda place: place.block if isinstance(place, Slot) else 0
    ranges: list[range] = []
    for text in zones.split(","):
        found = _RANGE.fullmatch(text.strip())
        if found is None:
            raise InputError(
                f"{text.strip()!r:.40} is no range of aisles",
                field="zones",
                advice="write blocks, or ranges such as 0-4,5-9",
            )
        ranges.append(range(int(found[1]), int(found[2] or found[1]) + 1))
    aisles = {aisle: zone for zone, part in reversed(list(enumerate(ranges))) for aisle in part}
    used = {item.place.aisle for item in pool.items if isinstance(item.place, Slot)}
    missing = sorted(used - set(aisles))
    twice = sorted(a for a, n in Counter(a for part in ranges for a in part).items() if n > 1)
    for faults, what in ((missing, "in no zone"), (twice, "in two zones")):
        if faults:
            raise InputError(
                f"aisle {faults[0]} is {what}", field="zones", advice="give each aisle one zone"
            )
    return lambda place: aisles[place.aisle] if isinstance(place, Slot) else 0
