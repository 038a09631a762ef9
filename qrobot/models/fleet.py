"""The vehicles of a model: one for every possible trip, and what each can hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Ints
from qrobot.errors import InfeasibleError
from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough

__all__ = ["TripLimits", "Vehicles", "fleet_of", "limits_of"]


@dataclass(frozen=True, slots=True, eq=False)
class Vehicles:
    """The vehicles of a model, the largest first."""

    capacities: Ints
    """Room of each in units of weight, shape (K,)"""
    names: tuple[str, ...]
    """What messages call each: the robot's id, with the trip when it makes several"""

    def __len__(self) -> int:
        return len(self.names)


@dataclass(frozen=True, slots=True, eq=False)
class TripLimits:
    """What every feasible plan keeps to: free cuts for a small model. All of shape (K,)."""

    most: Ints
    """The most items that fit"""
    least: Ints
    """The fewest items that the others leave over"""
    lightest: Ints
    """The least load that the others leave over, in units"""
    binding: npt.NDArray[np.bool_]
    """Whether as many items as fit in number could be too heavy"""


def fleet_of(instance: Instance, *, every_robot: bool = False) -> Vehicles:
    """Return the vehicles: one for each trip that a robot may make, the largest first.

    With `every_robot` all of them, as the paper counts its qubits, else no more than there are
    orders, for no plan uses more.
    """
    most = max(len(instance.orders), 1)
    names, rooms = [], []
    for robot, room in zip(instance.robots, instance.capacities.tolist(), strict=True):
        for trip in range(min(robot.trips, most)):
            names.append(robot.id if robot.trips == 1 else f"{robot.id} on trip {trip + 1}")
            rooms.append(room)
    order = sorted(range(len(rooms)), key=lambda k: -rooms[k])
    if not every_robot:
        order = order[:most]
    return Vehicles(
        np.array([rooms[k] for k in order], dtype=np.int64), tuple(names[k] for k in order)
    )


def limits_of(instance: Instance, fleet: Vehicles) -> TripLimits:
    """Return bounds of items and load for each vehicle.

    Raises
    ------
    InfeasibleError
        When the bounds contradict each other, with the reason.
    """
    n = instance.size
    rooms = fleet.capacities
    total = int(instance.weights.sum())
    unit = float(instance.unit)
    largest = f"no robot holds more than {float(max(r.capacity for r in instance.robots)):.12g}"
    lot = instance.order_weights
    if len(lot) and int(lot.max()) > int(rooms[0]):
        worst = instance.orders[int(lot.argmax())].id
        raise InfeasibleError(
            f"order {worst} weighs {int(lot.max()) * unit:.12g}: {largest}; "
            f"{what_is_enough(instance)}"
        )
    if total > int(rooms.sum()):
        raise InfeasibleError(
            f"total load {total * unit:.12g} exceeds {int(rooms.sum()) * unit:.12g}, the most that "
            f"{len(fleet)} trips hold in whole multiples of {unit:.12g}; "
            f"{what_is_enough(instance)}"
        )
    by_room = {room: _most_items(instance, room) for room in set(rooms.tolist())}
    most = np.array([by_room[room] for room in rooms.tolist()], dtype=np.int64)
    if int(most.sum()) < n:
        raise InfeasibleError(
            f"{len(fleet)} trips carry at most {int(most.sum())} of the {n} items: {largest}; "
            f"{what_is_enough(instance)}"
        )
    lightest = np.maximum(total - (rooms.sum() - rooms), 0)
    heaviest_first = np.sort(instance.weights)[::-1]
    reached = np.concatenate([[0], np.cumsum(heaviest_first)])
    least = np.maximum(np.searchsorted(reached, lightest), n - (most.sum() - most))
    if bool((least > most).any()):
        k = int(np.argmax(least - most))
        raise InfeasibleError(
            f"at least {int(least[k])} items are left for robot {fleet.names[k]}, whose "
            f"{int(rooms[k]) * unit:.12g} holds {int(most[k])}; {what_is_enough(instance)}"
        )
    return TripLimits(most, least, lightest, reached[most] > rooms)


def _most_items(instance: Instance, room: int) -> int:
    """Return the most items in whole orders that a vehicle holds."""
    lot = instance.order_weights
    if len(lot) == instance.size:
        return int((np.cumsum(np.sort(lot)) <= room).sum())
    # A knapsack: the least load of every number of items.
    lightest = np.full(instance.size + 1, np.inf)
    lightest[0] = 0.0
    for weight, nodes in zip(lot.tolist(), instance.order_nodes, strict=True):
        size = len(nodes)
        lightest[size:] = np.minimum(lightest[size:], lightest[:-size] + weight)
    return int(np.flatnonzero(lightest <= room)[-1])
