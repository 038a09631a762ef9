"""From routes to the sample that stands for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from qrobot._arrays import Bits
from qrobot.errors import InputError
from qrobot.models.compact import anchors
from qrobot.models.layout import VariableLayout
from qrobot.models.slack import slack_bits
from qrobot.problem import Instance

__all__ = ["encode_routes"]


def encode_routes(
    instance: Instance, layout: VariableLayout, routes: Sequence[Sequence[int]], *, canonical: bool
) -> Bits:
    """Return the variables of a plan, shape (variables,).

    Every vehicle collects from step 1 on without a break and then stays at the depot; the
    slack is what is left of its room.

    Parameters
    ----------
    instance, layout
        The question, the variables.
    routes
        For each vehicle its nodes in sequence; vehicles left out stay home. When a route
        is too heavy for its vehicle, the heaviest load goes to the largest one and so on.
    canonical
        Whether equal vehicles exchange trips as a model without symmetry demands.

    Raises
    ------
    InputError
        When the model has no variables for these routes.
    """
    seats = _seated(instance, layout, routes)
    if canonical:
        seats = _relabelled(instance, layout, seats)
    bits = np.zeros(layout.size, dtype=np.int8)
    for k, route in enumerate(seats):
        layers = int(layout.last[k]) - layout.first + 1 if layout.last[k] else 0
        stops = [0, *route] if layout.first == 0 else list(route)
        if len(stops) > layers:
            raise InputError(
                f"{len(route)} items are more than robot {layout.fleet.names[k]} can take",
                field=f"routes[{k}]",
                advice="give a plan that keeps to the capacities",
            )
        stops += [0] * (layers - len(stops))
        for t, node in enumerate(stops):
            where = layout.where.get((k, t + layout.first, node))
            if where is None:
                raise InputError(
                    f"the model has no variable for robot {layout.fleet.names[k]} at "
                    f"{instance.node_name(node)} at step {t + layout.first}",
                    field=f"routes[{k}]",
                    advice="give a plan that keeps to the capacities",
                )
            bits[where] = 1
        mine = np.flatnonzero(layout.slack_vehicle == k)
        left = int(layout.fleet.capacities[k]) - _load(instance, route)
        bits[layout.places + mine] = slack_bits(left, layout.slack_coefficient[mine])
    return bits


def _load(instance: Instance, route: Sequence[int]) -> int:
    return sum(int(instance.weights[v - 1]) for v in route)


def _seated(
    instance: Instance, layout: VariableLayout, routes: Sequence[Sequence[int]]
) -> list[list[int]]:
    """Return one route a vehicle, empty ones for those that stay home."""
    plan = [[int(v) for v in route] for route in routes]
    for k, route in enumerate(plan):
        for v in route:
            if not 1 <= v <= layout.items:
                raise InputError(
                    f"node {v} is not an item",
                    field=f"routes[{k}]",
                    advice=f"items are the nodes 1 to {layout.items}",
                )
    if len(plan) > len(layout.fleet):
        plan = [route for route in plan if route]
    if len(plan) > len(layout.fleet):
        raise InputError(
            f"{len(plan)} routes for {len(layout.fleet)} vehicles",
            field="routes",
            advice="give a route for each vehicle at most",
        )
    plan += [[] for _ in range(len(layout.fleet) - len(plan))]
    rooms = layout.fleet.capacities.tolist()
    if all(_load(instance, r) <= room for r, room in zip(plan, rooms, strict=True)):
        return plan
    heavy_first = sorted(plan, key=lambda r: -_load(instance, r))
    if all(_load(instance, r) <= room for r, room in zip(heavy_first, rooms, strict=True)):
        return heavy_first
    return plan


def _relabelled(
    instance: Instance, layout: VariableLayout, plan: list[list[int]]
) -> list[list[int]]:
    """Return the plan with the trips of equal vehicles sorted by their first anchor."""
    for group, nodes in anchors(instance, layout.fleet):
        rank = {node: r for r, node in enumerate(nodes)}
        trips = sorted(
            (plan[k] for k in group),
            key=lambda route: min((rank.get(v, len(rank)) for v in route), default=len(rank) + 1),
        )
        for k, route in zip(group, trips, strict=True):
            plan[k] = route
    return plan
