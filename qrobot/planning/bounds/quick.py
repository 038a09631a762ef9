"""What can be said at once: how many trips there must and need be, and a first bound."""

from __future__ import annotations

import numpy as np

from qrobot.problem import Instance

__all__ = ["fewest_trips", "is_metric", "most_trips", "quick_bound"]

MAX_METRIC_TEST = 300
"""Stops beyond which nobody looks whether the triangle inequality holds."""


def fewest_trips(instance: Instance) -> int:
    """Return a number of trips that no plan can stay below: the largest robots, filled."""
    total = int(instance.weights.sum())
    if not instance.orders:
        return 0
    reach = np.cumsum(instance.vehicle_capacities)
    return min(int(np.searchsorted(reach, total)) + 1, len(reach))


def most_trips(instance: Instance) -> int:
    """Return a number of trips that some shortest plan does not exceed.

    Two trips that fit on one robot together can be joined, unless the way between two
    stops is longer than over the depot; so at most one trip is half empty or less.
    """
    capacities = instance.vehicle_capacities
    d = instance.stop_distances
    joinable = bool((d[1:, 0, None] + d[None, 0, 1:] >= d[1:, 1:] - 1e-9).all())
    if not joinable or instance.whole_orders or capacities[0] != capacities[-1]:
        return len(capacities)
    total = int(instance.weights.sum())
    return min(len(capacities), max(1, 2 * total // max(int(capacities[0]), 1) + 1))


def quick_bound(instance: Instance) -> float:
    """Return a bound that costs nothing: every stop is entered, every trip comes home.

    Valid for any matrix: each stop must be entered from somewhere else and each trip must
    return to the depot; with a metric, the farthest stop must be fetched.
    """
    if not instance.items:
        return 0.0
    d = instance.stop_distances
    apart = d + np.where(np.eye(len(d), dtype=bool), np.inf, 0.0)
    entered = float(apart[:, 1:].min(axis=0).sum()) + fewest_trips(instance) * float(d[1:, 0].min())
    if is_metric(instance):
        return max(entered, float((d[0] + d[:, 0]).max()))
    return entered


def is_metric(instance: Instance) -> bool:
    """Return whether leaving a stop out never makes a way longer (False when unknown)."""
    d = instance.stop_distances
    if len(d) > MAX_METRIC_TEST:
        return False
    least = min(
        (float((d[:, k, None] + d[None, k, :] - d).min()) for k in range(len(d))), default=0.0
    )
    return least >= -1e-9 * float(d.max(initial=1.0))
