"""Pack orders onto trips, distances aside: a start for searches, or proof that none exists."""

from __future__ import annotations

import numpy as np

from qrobot.backends.base import Routes, Stop
from qrobot.backends.classical.cpsat import new_solver, solve
from qrobot.errors import MissingExtraError
from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough

__all__ = ["no_packing", "no_schedule", "no_way", "pack"]

MAX_BINARIES = 100_000


def pack(instance: Instance, stop: Stop, seed: int = 0) -> tuple[Routes | None, bool]:
    """Find any assignment of orders to trips with CP-SAT.

    Parameters
    ----------
    instance
        The question.
    stop
        Deadline and interrupts; a work limit becomes CP-SAT's deterministic time.
    seed
        Of the solver.

    Returns
    -------
    tuple
        Routes (stops in no useful sequence) or ``None``, and whether their absence is
        proven. Without OR-Tools: ``(None, False)``.
    """
    try:
        solver = new_solver("packing")
    except MissingExtraError:
        return None, False
    weights = instance.order_weights.tolist()
    capacities = instance.vehicle_capacities.tolist()
    if len(weights) * len(capacities) > MAX_BINARIES or stop():
        return None, False
    on = [[solver.BoolVar("") for _ in capacities] for _ in weights]
    for row in on:
        solver.Add(sum(row) == 1)
    for trip, capacity in enumerate(capacities):
        room = solver.Constraint(0, capacity)
        for order, weight in enumerate(weights):
            room.SetCoefficient(on[order][trip], weight)
    # Equal trips are interchangeable: the heaviest orders open them in sequence.
    heaviest = np.argsort(-np.array(weights), kind="stable")
    if len(set(capacities)) == 1:
        for rank, order in enumerate(heaviest[: len(capacities)].tolist()):
            for trip in range(rank + 1, len(capacities)):
                solver.Add(on[order][trip] == 0)
    status = solve(solver, stop, seed)
    if status == solver.INFEASIBLE:
        return None, True
    if status not in (solver.OPTIMAL, solver.FEASIBLE):
        return None, False
    routes: Routes = [[] for _ in capacities]
    for order, row in enumerate(on):
        trip = next(t for t, variable in enumerate(row) if variable.solution_value() > 0.5)
        routes[trip].extend(instance.order_nodes[order])
    return [route for route in routes if route], False


def no_packing(instance: Instance) -> str:
    """Return the sentence that says that every packing was tried."""
    capacities = instance.vehicle_capacities
    unit = float(instance.unit)
    sizes = sorted({f"{capacity * unit:.12g}" for capacity in capacities.tolist()})
    return (
        f"the {len(instance.orders)} orders (total load {instance.weights.sum() * unit:.12g}) "
        f"cannot be packed into {len(capacities)} trips of at most {' / '.join(sizes)} each: "
        f"every split was tried; {what_is_enough(instance)}"
    )


def no_schedule(instance: Instance) -> str:
    """Return the sentence that says that every schedule was tried."""
    if not instance.has_deadlines:
        return no_packing(instance)
    first = min(instance.orders, key=lambda order: order.deadline)
    return (
        f"no schedule of {len(instance.robots)} robots keeps all deadlines (the first: order "
        f"{first.id} at {first.deadline:.12g} s): every one was tried; give more time, more robots "
        "(--robots) or due times, which may be missed"
    )


def no_way(instance: Instance) -> str:
    """Return the sentence that says that every trip along the ways that exist was tried."""
    return (
        f"no plan for the {len(instance.orders)} orders does without a way that does not exist "
        "(null in the distances): every split and every sequence was tried"
    )
