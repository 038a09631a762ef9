"""From samples to routes (what each means, violates and costs), and from routes to samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Bits, Bools
from qrobot.errors import InputError
from qrobot.models.encodings import anchors
from qrobot.models.layout import VariableLayout
from qrobot.models.slack import slack_bits
from qrobot.problem import Instance

__all__ = [
    "Decoded",
    "Reads",
    "Violation",
    "bits_of",
    "decode_row",
    "decode_rows",
    "encode_routes",
]


CELLS = 20_000_000
"""Grid cells that are judged at a time: 20 MB."""


@dataclass(frozen=True, slots=True)
class Violation:
    """One broken constraint.

    Parameters
    ----------
    kind
        ``step``: a robot is in several places at once, or in none. ``visit``: an item is
        collected several times, or never. ``capacity``: a load is too heavy. ``split
        order``: an order is on several trips. ``depot``: a robot does not start or end at
        the depot. ``way``: no way leads directly from one place to the next.
    text
        The fact, as a sentence.
    amount
        By how much: places above or below one, visits above or below one, units of weight
        above the capacity, trips above one.
    robot, step, item, order
        Where: index of the vehicle, step, index of the item, index of the order.
    """

    kind: Literal["step", "visit", "capacity", "split order", "depot", "way"]
    text: str
    amount: int
    robot: int | None = None
    step: int | None = None
    item: int | None = None
    order: int | None = None


@dataclass(frozen=True, slots=True)
class Decoded:
    """What a sample says.

    Parameters
    ----------
    routes
        For each vehicle the nodes (item index + 1) by step; visits of the depot on the way
        are left out. Of a sample with violations: everything as sampled, items that are
        collected twice included.
    violations
        Every broken constraint.
    energy
        Of the sample.
    distance
        Length of the routes, ``inf`` when a constraint is broken.
    """

    routes: list[list[int]]
    violations: tuple[Violation, ...]
    energy: float
    distance: float

    @property
    def feasible(self) -> bool:
        """Whether no constraint is broken."""
        return not self.violations


class Reads(NamedTuple):
    """What many samples say.

    Parameters
    ----------
    feasible
        Whether no constraint is broken, shape (reads,).
    distances
        Length of the routes, ``inf`` when one is, shape (reads,).
    """

    feasible: Bools
    distances: npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Judged:
    """Sums over a block of samples; R reads, K vehicles, T steps, n items."""

    grid: Bools
    """(R, K, T, n + 1)"""
    places: npt.NDArray[np.int64]
    """(R, K, T): how many places at once"""
    visits: npt.NDArray[np.int64]
    """(R, n)"""
    loads: npt.NDArray[np.int64]
    """(R, K)"""
    trips: npt.NDArray[np.int64]
    """(R, orders): vehicles that carry some of it"""
    away: Bools
    """(R, K, 2): not at the depot at the start, at the end"""


def decode_rows(instance: Instance, layout: VariableLayout, bits: Bits) -> Reads:
    """Judge samples, shape (reads, variables) of 0 and 1 in the layout's order."""
    cells = max(1, len(layout.fleet) * layout.steps * (layout.items + 1))
    height = max(1, CELLS // cells)
    parts = [
        _reads(instance, layout, _judged(instance, layout, bits[top : top + height]))
        for top in range(0, max(len(bits), 1), height)
    ]
    return Reads(
        np.concatenate([p.feasible for p in parts]), np.concatenate([p.distances for p in parts])
    )


def _judged(instance: Instance, layout: VariableLayout, bits: Bits) -> _Judged:
    """Sum up samples, constraint by constraint."""
    reads, robots = len(bits), len(layout.fleet)
    n, steps = layout.items, layout.steps
    flat = np.zeros((reads, robots * steps * (n + 1)), dtype=np.bool_)
    flat[:, layout.cell] = bits[:, : layout.places] > 0
    grid = flat.reshape(reads, robots, steps, n + 1)
    picks = grid[..., 1:].sum(axis=2)
    return _Judged(
        grid=grid,
        places=grid.sum(axis=3),
        visits=picks.sum(axis=1),
        loads=(picks @ instance.weights).astype(np.int64),
        trips=_trips_of_orders(instance, picks > 0),
        away=_away(layout, grid),
    )


def _trips_of_orders(instance: Instance, carried: Bools) -> npt.NDArray[np.int64]:
    if len(instance.orders) == instance.size:
        return np.zeros((len(carried), 0), dtype=np.int64)
    member = np.zeros((instance.size, len(instance.orders)), dtype=np.int64)
    member[np.arange(instance.size), instance.order_of_node[1:]] = 1
    return np.asarray(((carried.astype(np.int64) @ member) > 0).sum(axis=1))


def _away(layout: VariableLayout, grid: Bools) -> Bools:
    if layout.first:
        return np.zeros((*grid.shape[:2], 2), dtype=np.bool_)
    return ~grid[:, :, [0, layout.items + 1], 0]


def _reads(instance: Instance, layout: VariableLayout, judged: _Judged) -> Reads:
    exists = np.arange(layout.steps) < layout.layers[:, None]
    feasible = (
        ((judged.places == 1) | ~exists).all(axis=(1, 2))
        & (judged.visits == 1).all(axis=1)
        & (judged.loads <= layout.fleet.capacities).all(axis=1)
        & (judged.trips <= 1).all(axis=1)
        & ~judged.away.any(axis=(1, 2))
    )
    distances = np.full(len(feasible), np.inf)
    nodes = judged.grid[feasible].argmax(axis=3)
    # Visits of the depot go to the end: the sequence of the items is what counts.
    order = np.argsort(nodes == 0, axis=2, kind="stable")
    nodes = np.take_along_axis(nodes, order, axis=2)
    home = np.zeros((*nodes.shape[:2], 1), dtype=nodes.dtype)
    ways = np.concatenate([home, nodes, home], axis=2)
    rows = instance.place_of_node[ways]
    # As driven, not as priced: infinite where no way leads.
    distances[feasible] = instance.place_distances[rows[..., :-1], rows[..., 1:]].sum(axis=(1, 2))
    return Reads(np.isfinite(distances), distances)


def decode_row(instance: Instance, layout: VariableLayout, bits: Bits, energy: float) -> Decoded:
    """Return routes and violations of one sample, shape (variables,)."""
    judged = _judged(instance, layout, bits[None, :])
    grid = judged.grid[0]
    routes = [[int(i) for i in np.nonzero(vehicle[:, 1:])[1] + 1] for vehicle in grid]
    violations = tuple(_violations(instance, layout, judged)) or tuple(_ways(instance, routes))
    return Decoded(
        routes=routes,
        violations=violations,
        energy=energy,
        distance=float("inf") if violations else instance.length(routes),
    )


def _violations(instance: Instance, layout: VariableLayout, judged: _Judged) -> Iterator[Violation]:
    names = layout.fleet.names
    for k, layers in enumerate(layout.layers.tolist()):
        for t in range(layers):
            count, step = int(judged.places[0, k, t]), t + layout.first
            if count != 1:
                where = "nowhere" if not count else f"in {count} places"
                text = f"robot {names[k]} is {where} at step {step}"
                yield Violation("step", text, count - 1, robot=k, step=step)
        for end, side in enumerate(("start", "end")):
            if judged.away[0, k, end]:
                step = (layout.items + 1) * end
                text = f"robot {names[k]} does not {side} at the depot"
                yield Violation("depot", text, 1, robot=k, step=step)
    for i, count in enumerate(judged.visits[0].tolist()):
        if count != 1:
            times = "never" if not count else f"{count} times"
            text = f"item {instance.items[i].id} is collected {times}"
            yield Violation("visit", text, count - 1, item=i)
    unit = instance.unit
    for k, load in enumerate(judged.loads[0].tolist()):
        room = int(layout.fleet.capacities[k])
        if load > room:
            text = (
                f"robot {names[k]} carries {float(load * unit):.12g}, "
                f"{float((load - room) * unit):.12g} more than the {float(room * unit):.12g} it can"
            )
            yield Violation("capacity", text, load - room, robot=k)
    for o, count in enumerate(judged.trips[0].tolist()):
        if count > 1:
            text = f"order {instance.orders[o].id} is split over {count} trips"
            yield Violation("split order", text, count - 1, order=o)


def _ways(instance: Instance, routes: list[list[int]]) -> Iterator[Violation]:
    """Name the ways of a plan that do not exist."""
    row = instance.place_of_node
    for k, route in enumerate(routes):
        corners = [0, *route, 0] if route else []
        for a, b in pairwise(corners):
            if np.isinf(instance.place_distances[row[a], row[b]]):
                start, end = instance.node_name(a), instance.node_name(b)
                text = f"no way leads directly from {start} to {end}"
                yield Violation("way", text, 1, robot=k)


def bits_of(layout: VariableLayout, sample: Any) -> Bits:
    """Return a sample (label to value; 0/1, bool or spin) as 0 and 1 in the layout's order."""
    return np.array([sample[label] > 0 for label in layout.labels], dtype=np.int8)


def encode_routes(
    instance: Instance, layout: VariableLayout, routes: Sequence[Sequence[int]], *, canonical: bool
) -> Bits:
    """Return the variables of a plan, shape (variables,), as `PickingModel.encode` has them.

    Every vehicle collects from step 1 on without a break and then stays at the depot; the
    slack is what is left of its room. `canonical` lets equal vehicles exchange trips as a model
    without symmetry demands.
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
