"""The last step of a run in aisles: no trip is longer than the shortest tour past its places."""

from __future__ import annotations

import math

from qrobot.backends import Stop
from qrobot.planning.run import TIE, Run
from qrobot.problem import AisleWarehouse
from qrobot.warehouse import MAX_CROSS_AISLES
from qrobot.warehouse.routing import Router

__all__ = ["shorten_tours"]

SHARE, GRACE = 0.2, 0.2
"""Of the time that is left, for the bound too; seconds that it gets when none is left."""


def shorten_tours(run: Run) -> None:
    """Walk the trips of the best plan by shortest tours, where the layout has an exact method.

    Searches over distances and samplers leave trips behind that go a longer way past the same
    places. Trips that a policy walks, or along one-way aisles, stay as they are; so do the shorter
    trips when time is over.
    """
    instance, routes = run.instance, run.best.routes
    warehouse = instance.warehouse
    if (
        routes is None
        or run.finished
        or instance.routing != "exact"
        or not isinstance(warehouse, AisleWarehouse)
        or warehouse.is_one_way
        or warehouse.blocks >= MAX_CROSS_AISLES
    ):
        return
    left = run.stop.remaining
    stop = run.stop.within(SHARE * left if math.isfinite(left) else None) if left else Stop(GRACE)
    router = Router(warehouse)
    shortened = [list(route) for route in routes]
    gained = False
    with run.timed("run"):
        # The longest first: there is most to gain.
        for k in sorted(range(len(routes)), key=lambda k: -instance.route_length(routes[k])):
            if stop():
                break
            length, route = router.route(instance, routes[k])
            if length < instance.route_length(routes[k]) * (1.0 - TIE):
                shortened[k], gained = route, True
    if gained:
        run.begin("tours")
        run.best.offer(shortened)
