"""Other fleets: so many robots as asked, and what would certainly be enough."""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from itertools import count as numbers
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from qrobot.errors import InputError
from qrobot.problem.entities import Robot
from qrobot.problem.validity import MAX_ITEMS

if TYPE_CHECKING:  # an instance makes its other fleets by this file
    from qrobot.problem.instance import Instance

__all__ = ["NO_LIMIT", "check_fleet_size", "fleet_of_size", "what_is_enough", "with_trips"]

MOST_TRIED = 2_000
"""Orders beyond which capacities are not tried."""

NO_LIMIT = MAX_ITEMS
"""Trips of a robot that may make any number: as many as there may be orders."""

DIGITS = 6
"""Decimals of an advised capacity, rounded up."""


def check_fleet_size(count: int, field: str) -> None:
    """Refuse a number of robots that no plan may have."""
    if count < 1:
        raise InputError(
            f"{count} robots are too few", field=field, advice="give 1 or more, or 'free'"
        )
    if count > MAX_ITEMS:
        raise InputError(
            f"{count} robots are more than {MAX_ITEMS}", field=field, advice="give fewer"
        )


def fleet_of_size(robots: tuple[Robot, ...], count: int | None, orders: int) -> tuple[Robot, ...]:
    """Return so many robots; ``None`` sets no limit, which means a trip for each order."""
    if count is None:
        largest = max(robots, key=lambda r: r.capacity)
        return tuple(
            dataclasses.replace(largest, id=f"R{k + 1}", trips=1) for k in range(max(orders, 1))
        )
    if isinstance(count, bool) or not isinstance(count, int):
        problem, advice = "is not a number of robots", "give a whole number above 0, or 'free'"
        raise InputError(f"{count!r} {problem}", field="robots", advice=advice)
    check_fleet_size(count, "robots")
    if count <= len(robots):
        return robots[:count]
    if len({(r.capacity, r.speed, r.trips, r.available) for r in robots}) > 1:
        raise InputError(
            f"{count} robots are more than the {len(robots)} that there are, and these are not "
            "alike",
            field="robots",
            advice=f"give at most {len(robots)}, describe more of them in the file, or give 'free'",
        )
    used = {robot.id for robot in robots}
    names = (name for k in numbers(1) if (name := f"R{k}") not in used)
    more = islice(names, count - len(robots))
    return (*robots, *(dataclasses.replace(robots[0], id=name) for name in more))


def with_trips(robots: tuple[Robot, ...], trips: int | str) -> tuple[Robot, ...]:
    """Return the robots with so many trips each; ``free`` sets no limit."""
    if trips == "free":
        trips = NO_LIMIT
    if isinstance(trips, bool) or not isinstance(trips, int) or not 1 <= trips <= NO_LIMIT:
        raise InputError(
            f"{trips!r} is not a number of trips from 1 to {NO_LIMIT}",
            field="trips",
            advice="give a whole number above 0, or 'free'",
        )
    return tuple(dataclasses.replace(robot, trips=trips) for robot in robots)


def what_is_enough(instance: Instance) -> str:
    """Return a clause that names options under which a plan exists, each by itself.

    Not the least that could do, but what a first-fit packing (heaviest first) proves to do.
    """
    options = []
    weights = instance.order_weights.tolist()
    largest = int(instance.vehicle_capacities[0])
    alike = len({(r.capacity, r.speed, r.trips) for r in instance.robots}) == 1
    if max(weights) <= largest:
        if alike:
            trips = instance.robots[0].trips
            count = math.ceil(len(_first_fit(weights, [largest] * len(weights)) or []) / trips)
            options.append(f"{count} robots (--robots {count})")
        else:
            options.append("as many of the largest robot as wanted (--robots free)")
        if any(robot.trips < len(weights) for robot in instance.robots):
            options.append("several trips of each robot (--trips free)")
    seats = sum(min(robot.trips, len(weights)) for robot in instance.robots)
    capacity = _written(_least_capacity(weights, seats) * instance.unit)
    options.append(f"a capacity of {capacity} (--capacity {capacity})")
    if len(instance.orders) < instance.size:
        single = instance.split_orders()
        rooms = single.vehicle_capacities.tolist()
        if _first_fit(single.order_weights.tolist(), rooms) is not None:
            options.append("orders that may be split (--split-orders)")
    return "enough would be " + ", or ".join(options)


def _first_fit(weights: list[int], rooms: list[int]) -> list[int] | None:
    """Return the trips that are used, heaviest orders first, None if one finds no room."""
    left = np.array(rooms, dtype=np.int64)
    used = np.zeros(len(rooms), dtype=bool)
    for weight in sorted(weights, reverse=True):
        fits = left >= weight
        if not fits.any():
            return None
        at = int(fits.argmax())
        left[at] -= weight
        used[at] = True
    return [int(at) for at in np.flatnonzero(used)]


def _least_capacity(weights: list[int], seats: int) -> int:
    """Return a small capacity with which so many trips surely hold everything."""
    low = max(*weights, -(-sum(weights) // seats), 1)
    # A load that fits nowhere finds every trip fuller than the mean: this is always enough.
    high = max(sum(weights) // seats + max(weights), 1)
    if len(weights) > MOST_TRIED:
        return high
    while low < high:  # first fit is not monotone: what is returned was tried
        middle = (low + high) // 2
        if _first_fit(weights, [middle] * seats) is None:
            low = middle + 1
        else:
            high = middle
    return high


def _written(value: Fraction) -> str:
    """Return a number as people write it, rounded up."""
    digits = math.ceil(value * 10**DIGITS)
    text = f"{digits // 10**DIGITS}.{digits % 10**DIGITS:0{DIGITS}d}"
    return text.rstrip("0").rstrip(".")
