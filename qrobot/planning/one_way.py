"""Trips along one-way aisles get shortest tours where these can be found exactly."""

from __future__ import annotations

from qrobot.backends import Routes
from qrobot.planning.run import Run
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.one_way import EXACT_STOPS, one_way_tour

__all__ = ["shorten_trips"]

SECONDS, FAST_STOPS = 0.3, 10
"""A tour of `EXACT_STOPS` stops takes less time; with less left, only those of so few stops, which
take a few milliseconds, are exact."""


def shorten_trips(run: Run) -> None:
    """Give the trips of a run's plan their shortest tours, where aisles are one-way.

    Its orders stay on their trips; a note says where a tour may not be a shortest one.
    """
    instance, routes = run.instance, run.best.routes
    if not isinstance(instance.warehouse, AisleWarehouse) or not instance.warehouse.is_one_way:
        return
    if routes is None or run.finished:
        return
    with run.timed("run"):
        proven, least = _shorten(run, instance.warehouse, routes)
    if not (all(proven) or run.finished):
        run.record.notes.append(
            f"some aisles are one-way: tours of more than {least} stops are not proven shortest "
            f"({proven.count(False)} of {len(proven)} here)"
        )


def _shorten(run: Run, warehouse: AisleWarehouse, routes: Routes) -> tuple[list[bool], int]:
    """Offer the plan with its shortest tours.

    Returns
    -------
    tuple
        Whether each tour is a shortest one, and up to how many stops all are.
    """
    instance = run.instance
    shorter, proven, least = [], [], EXACT_STOPS
    for route in routes:
        slots = [s for v in route if isinstance(s := instance.items[v - 1].place, Slot)]
        most = EXACT_STOPS if run.stop.remaining > SECONDS else FAST_STOPS
        least = min(least, most)
        _, sequence, shortest = one_way_tour(warehouse, slots, exact_stops=most)
        found = [route[i] for i in sequence]
        shorter.append(min((route, found), key=instance.route_length))
        proven.append(shortest)
    run.best.offer(shorter)
    return proven, least
