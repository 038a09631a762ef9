"""Why no plan exists, and what would be enough, in one sentence."""

from __future__ import annotations

from collections import defaultdict

from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough

__all__ = ["reason_infeasible"]

MOST_NAMED = 5


def reason_infeasible(instance: Instance) -> str | None:
    """Return an obvious reason why no plan exists and what would be enough, or None.

    Checks every order against the largest robot, the total load against the fleet, and
    orders that are too heavy to share a trip against the number of trips.
    """
    reason = _reason(instance)
    return None if reason is None else f"{reason}; {what_is_enough(instance)}"


def _reason(instance: Instance) -> str | None:
    if not instance.orders:
        return None
    capacities = instance.vehicle_capacities.tolist()
    unit = instance.unit
    weights = instance.order_weights.tolist()
    largest = capacities[0]
    too_heavy: dict[int, list[str]] = defaultdict(list)
    for order, weight in zip(instance.orders, weights, strict=True):
        if weight > largest:
            too_heavy[weight].append(order.id)
    if too_heavy:
        room = f"no robot holds more than {float(max(r.capacity for r in instance.robots)):.12g}"
        parts = [
            _weighs(instance, ids, float(weight * unit))
            for weight, ids in sorted(too_heavy.items(), reverse=True)[:MOST_NAMED]
        ]
        reason = f"{'; '.join(parts)}: {room}"
        if len(too_heavy) > MOST_NAMED:
            reason += f" (and {len(too_heavy) - MOST_NAMED} heavier weights)"
        return reason
    total = sum(weights)
    if total > sum(int(instance.capacities[r]) * k.trips for r, k in enumerate(instance.robots)):
        reason = f"total load {float(total * unit):.12g} exceeds {_fleet(instance)}"
        if total * unit <= sum(robot.capacity * robot.trips for robot in instance.robots):
            reason = (
                f"total load {float(total * unit):.12g} does not fit: all weights are multiples of "
                f"{float(unit):.12g}, so {_fleet(instance)} hold at most "
                + " + ".join(
                    f"{robot.trips} x {float(int(instance.capacities[r]) * unit):.12g}"
                    for r, robot in enumerate(instance.robots)
                )
            )
        return reason
    # Two orders above half of the largest capacity never share a trip.
    halves = sum(1 for weight in weights if 2 * weight > largest)
    if halves > len(capacities):
        return (
            f"{halves} orders weigh more than half of the largest robot's "
            f"{float(largest * unit):.12g}, so no two of them share a trip, but only "
            f"{len(capacities)} trips are possible"
        )
    return None


def _weighs(instance: Instance, ids: list[str], weight: float) -> str:
    single = all(len(o.items) == 1 for o in instance.orders)
    noun = "item" if single else "order"
    shown = ", ".join(ids[:MOST_NAMED])
    if len(ids) > MOST_NAMED:
        shown += f" and {len(ids) - MOST_NAMED} more"
    return (
        f"{noun} {shown} weighs {weight:.12g}"
        if len(ids) == 1
        else (f"{noun}s {shown} weigh {weight:.12g} each")
    )


def _fleet(instance: Instance) -> str:
    """Return the fleet's room as a sum, such as ``4 x 15`` or ``2 x 15 + 1 x 10``."""
    counts: dict[float, int] = defaultdict(int)
    for robot in instance.robots:
        counts[float(robot.capacity)] += robot.trips
    return " + ".join(f"{n} x {room:.12g}" for room, n in sorted(counts.items(), reverse=True))
