"""Choice of places for articles that lie in several, together with the tour past them."""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from qrobot import _jit
from qrobot._extras import is_installed
from qrobot.backends.base import Stop
from qrobot.backends.classical import cpsat
from qrobot.backends.classical.aisles import PLACES, compiled_soon
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Place, Slot, Stock
from qrobot.problem.entities import picked
from qrobot.warehouse import MAX_CROSS_AISLES, Router
from qrobot.warehouse.prices import Relaxed, relax
from qrobot.warehouse.scattered import Network, Offer, network_of, step_of

__all__ = ["Placed", "can_choose", "choose_places"]

FIRST = 0.01
"""The first search looks at tours that are longer than the bound by this share."""

WIDEST = 0.02
"""Labels are made for tours longer than the bound by at most this share at a time."""


@dataclass(frozen=True, slots=True)
class Placed:
    """An instance whose items lie in chosen places.

    Parameters
    ----------
    instance
        The same question, asked of these places.
    route
        Nodes of one tour past all of them.
    bound
        No tour, and so no plan, is shorter for any choice of places; metres.
    """

    instance: Instance
    route: list[int]
    bound: float


def can_choose(instance: Instance) -> bool:
    """Return whether places can be chosen: a stock, aisles, and OR-Tools is installed."""
    warehouse = instance.warehouse
    return (
        bool(instance.demand)
        and instance.routing == "exact"
        and isinstance(warehouse, AisleWarehouse)
        and warehouse.blocks < MAX_CROSS_AISLES
        and not warehouse.is_one_way
        and is_installed("ortools")
    )


def choose_places(instance: Instance, stop: Stop) -> Placed | None:
    """Return the places of a shortest tour past all that is asked for, or None for lack of time.

    Capacities are passed over: all orders are collected on one tour.
    """
    warehouse = instance.warehouse
    assert isinstance(warehouse, AisleWarehouse)
    articles = list(instance.demand)
    index = {name: k for k, name in enumerate(articles)}
    asked = list(instance.demand.values())
    offers = [
        Offer(index[one.article], one.place, one.quantity)
        for one in instance.stock
        if one.article in index and isinstance(one.place, Slot)
    ]
    for item in instance.items:  # what has no stock has one place
        if item.article not in index and isinstance(item.place, Slot):
            offers.append(Offer(len(asked), item.place, 1))
            asked.append(1)
    chosen, bound = _shortest(network_of(warehouse, offers, asked), step_of(warehouse), stop)
    if chosen is None:
        return None
    left = list(asked)
    taken: defaultdict[str, list[tuple[Place, int]]] = defaultdict(list)
    for k in sorted(chosen, key=lambda k: -offers[k].quantity):
        offer = offers[k]
        pieces = min(offer.quantity, left[offer.article])
        left[offer.article] -= pieces
        if pieces and offer.article < len(articles):
            taken[articles[offer.article]].append((offer.slot, pieces))
    placed = _placed(instance, taken)
    slots = [item.place for item in placed.items if isinstance(item.place, Slot)]
    route = [1 + i for i in Router(warehouse, compiled=False).tour(slots).sequence]
    return Placed(placed, route, bound)


def _shortest(network: Network, step: float, stop: Stop) -> tuple[set[int] | None, float]:
    """Return the offers that the best tour found passes, and a bound of a shortest one's length.

    Only what may be on a tour of some length is looked at. A tour that is not longer is a
    shortest one; otherwise the length of the tour that was found, or a larger guess, is next.
    """
    compiled = _jit.available() and compiled_soon(stop, PLACES)
    relaxed = relax(network, compiled=compiled)
    if math.isinf(relaxed.bound):
        return None, 0.0
    bound = math.ceil(relaxed.bound / step - 1e-6) * step
    if compiled:
        bound, chosen = _by_labels(relaxed, bound, step, stop)
        if chosen is not None:
            return chosen, bound
    room = max(2.0, math.ceil(FIRST * bound / step)) * step
    limit = bound + room
    chosen = None
    finite = [every[np.isfinite(every)] for every in (relaxed.arcs, relaxed.choices)]
    all_in = max((float(every.max()) for every in finite if every.size), default=0.0)
    while not stop():
        found = _solve(relaxed.within(limit + step / 4), stop)
        if found is None:
            break
        length, offers = found
        if math.isinf(length) and limit >= all_in:
            break  # there is no tour
        if offers is not None:
            chosen = offers
        if length <= limit + step / 4:
            return chosen, length
        bound = max(bound, limit)
        limit, room = (length, room) if math.isfinite(length) else (limit + 4 * room, 4 * room)
    return chosen, bound


def _by_labels(
    relaxed: Relaxed, bound: float, step: float, stop: Stop
) -> tuple[float, set[int] | None]:
    """Return the length of a shortest tour and its offers; a better bound where labels are many."""
    from qrobot.warehouse.labels import shortest_within  # imports numba

    room = 0.0
    while not stop():
        found = shortest_within(relaxed, bound + room + step / 4)
        if found is None:
            break
        if found[1]:
            return found
        bound, room = bound + room + step, min(max(step, 2.0 * room), WIDEST * bound)
    return bound, None


def _solve(network: Network, stop: Stop) -> tuple[float, set[int] | None] | None:
    """Return the length of a shortest tour in a network and the offers it passes.

    ``inf`` when there is none; None when the time was too short.
    """
    choices, arcs = network.choices, len(network.tails)
    if not arcs:
        return math.inf, None
    solver = cpsat.new_solver("scattered storage", "SCIP")
    use = [solver.IntVar(0, 1, "") for _ in range(arcs + len(choices.costs))]
    objective = solver.Objective()
    for variable, cost in zip(use, [*network.costs.tolist(), *choices.costs.tolist()], strict=True):
        objective.SetCoefficient(variable, cost)
    flow = [solver.Constraint(0, 0) for _ in range(network.nodes)]
    flow[0].SetBounds(1, 1)
    flow[-1].SetBounds(-1, -1)
    names = {*network.groups.tolist(), *choices.groups.tolist()} - {-1}
    groups = {name: solver.Constraint(0, 0) for name in names}
    for variable, tail, head, group in zip(
        use,
        network.tails.tolist(),
        network.heads.tolist(),
        network.groups.tolist(),
        strict=False,
    ):
        flow[tail].SetCoefficient(variable, 1)
        flow[head].SetCoefficient(variable, -1)
        if group >= 0:
            groups[group].SetCoefficient(variable, 1)
    for variable, group in zip(use[arcs:], choices.groups.tolist(), strict=True):
        groups[group].SetCoefficient(variable, -1)
    enough = [solver.Constraint(pieces, solver.infinity()) for pieces in network.demand.tolist()]
    for row, article in np.argwhere(choices.pieces).tolist():
        enough[article].SetCoefficient(use[arcs + row], int(choices.pieces[row, article]))
    solver.SetSolverSpecificParametersAsString("limits/gap = 0")  # the default stops short
    status = cpsat.run(solver, stop)
    if status == solver.INFEASIBLE:
        return math.inf, None
    if status != solver.OPTIMAL:
        return None
    passed = {
        offer
        for choice, variable in enumerate(use[arcs:])
        if variable.solution_value() > 0.5
        for offer in choices.offers(choice)
    }
    return float(objective.Value()), passed


def _placed(instance: Instance, taken: dict[str, list[tuple[Place, int]]]) -> Instance:
    """Return the instance with the items of each order taken from given places."""
    items = {item.id: item for item in instance.items}
    left = {article: list(places) for article, places in taken.items()}
    bins = {(one.article, one.place): one for one in instance.stock}
    made: list[Item] = []
    orders: list[Order] = []
    names = set(items)
    for order in instance.orders:
        first = len(made)
        groups: defaultdict[str, list[Item]] = defaultdict(list)
        for name in order.items:
            one = items[name]
            groups[one.article if one.article in taken else f"\n{name}"].append(one)
        for article, group in groups.items():
            if article in left:
                made += _picks(group, left[article], names, bins)
            else:
                made += group
        orders.append(dataclasses.replace(order, items=tuple(item.id for item in made[first:])))
    return dataclasses.replace(instance, items=tuple(made), orders=tuple(orders))


def _picks(
    group: Sequence[Item],
    left: list[tuple[Place, int]],
    names: set[str],
    bins: Mapping[tuple[str, Place], Stock],
) -> list[Item]:
    """Return the items of an order and article, taken from what is left of its places."""
    wanted = sum(item.quantity for item in group)
    picks: list[tuple[Place, int]] = []
    while wanted:
        place, there = left.pop(0)
        took = min(there, wanted)
        wanted -= took
        picks.append((place, took))
        if there > took:
            left.insert(0, (place, there - took))
    known = [item.id for item in group]
    stem = known[0].removesuffix("#1")
    if len(picks) == 1 and (stem not in names or stem == known[0]):
        known = [stem]
    number = 1
    while len(known) < len(picks):
        name = f"{stem}#{number}"
        if name not in names:
            names.add(name)
            known.append(name)
        number += 1
    return [
        picked(group, name, bins[group[0].article, place], took)
        for name, (place, took) in zip(known, picks, strict=False)
    ]
