"""What no plan of a whole pool is below, however it is cut into waves."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends import Stop
from qrobot.backends.classical.aisles import TOURS, compiled_soon, takes
from qrobot.errors import InputError
from qrobot.problem import MAX_STOPS, AisleWarehouse, Instance, Place, Slot
from qrobot.problem.validity import some
from qrobot.warehouse import Router

__all__ = ["pool_bound"]

BLOCK = 200
"""Places whose distances are looked at together: few, so that a pool never has its whole matrix."""


def pool_bound(pool: Instance, stop: Stop | None = None) -> float:
    """Return a length that no plan of a pool is below, metres: cut or whole, in any trips.

    For each order let r(o) be a length that no trip which collects it is below: in aisles that of
    a shortest tour past its places, elsewhere that of the way out to the farthest of them and
    back. Where an article has a stock, the nearest of its places counts. A trip that collects
    several orders is no shorter than the largest of their r(o), as leaving stops out
    lengthens no trip. So the argument of `qrobot.planning.bounds.radial_bound` holds: the
    orders with r(o) >= x need at least N(x) trips of length x or more, and the integral of N(x) is
    a bound. N(x) counts trips of the largest robot, as many as are wanted.

    Zero where ways over other places may be shorter than direct ones and more than `MAX_STOPS`
    places would have to be looked at.

    Parameters
    ----------
    pool
        All orders.
    stop
        Without time to compile the kernel of tours, the ways out and back count in aisles, too.

    Raises
    ------
    InputError
        When no way leads to an item.
    """
    if not pool.orders:
        return 0.0
    least = _least_trips(pool, stop or Stop())
    farthest_first = np.argsort(-least, kind="stable")
    weights = pool.order_weights[farthest_first]
    room = int(pool.capacities.max())
    if int(weights.max()) > room:
        return 0.0  # there is no plan at all
    trips = np.maximum(-(-np.cumsum(weights) // max(room, 1)), np.cumsum(2 * weights > room))
    steps = -np.diff(least[farthest_first], append=0.0)
    return float(steps @ np.maximum(trips, 1))


def _least_trips(pool: Instance, stop: Stop) -> Floats:
    """Return for each order a length that no trip which collects it is below."""
    places: dict[str, list[Place]] = defaultdict(list)
    for one in pool.stock:
        places[one.article].append(one.place)
    known = list(dict.fromkeys([*pool.places, *(one.place for one in pool.stock)]))
    away = dict(zip(known, _there_and_back(pool, known).tolist(), strict=True))
    unreachable = [i.id for i in pool.items if not np.isfinite(away[i.place])]
    if unreachable:
        raise InputError(
            f"no way leads from the depot to items {some(unreachable)} and back",
            field="items",
            advice="move the items",
        )
    least = np.zeros(len(pool.orders))
    picks: list[list[Slot]] = []
    for o, nodes in enumerate(pool.order_nodes):
        items = [pool.items[v - 1] for v in nodes]
        reach = max(min(away[p] for p in places.get(i.article, [i.place])) for i in items)
        fixed = [i.place for i in items if i.article not in places]
        picks.append([place for place in fixed if isinstance(place, Slot)])
        least[o] = reach
    house = pool.warehouse
    if isinstance(house, AisleWarehouse) and takes(pool) and compiled_soon(stop, TOURS):
        return np.maximum(least, Router(house).lengths(picks))
    return least


def _there_and_back(pool: Instance, places: list[Place]) -> Floats:
    """Return the lengths of the shortest ways to places and back, over any of them."""
    house = pool.warehouse
    if not house.is_metric:
        if len(places) > MAX_STOPS:
            return np.zeros(len(places))
        d = house.distance_matrix(places)
        return (_from_depot(d) + _from_depot(d.T))[1:]
    found = np.zeros(len(places))
    for first in range(0, len(places), BLOCK):
        d = house.distance_matrix(places[first : first + BLOCK])
        found[first : first + BLOCK] = d[0, 1:] + d[1:, 0]
    return found


def _from_depot(d: Floats) -> Floats:
    """Return the lengths of the shortest ways from row 0, with one more way at every turn."""
    reach: Floats = d[0]
    longer = np.full(len(d), np.inf)
    while (reach < longer).any():
        longer, reach = reach, np.minimum(reach, (reach[:, None] + d).min(axis=0))
    return reach
