"""The encodings: which variables a model has.

**full** and **reduced** are the paper's. The full encoding has x[t, i, p] for every step
t = 0 .. n + 1, every node i = 0 .. n and every robot p: K (n + 1) (n + 2) variables and the
slack. Being at the depot at both ends is a constraint like the others. Table 1 of the paper
counts these. The reduced one has the depot's layers t = 0 and t = n + 1 put in as the constants
that the constraints make them: K n (n + 1) variables and the slack, as in tables 2 and 3.

**compact** has no variable that every feasible plan would set the same way. Each vehicle p has
steps 1 .. L[p], with L[p] the most items that fit it. The first m[p] of them, the items that
the other vehicles must leave over, cannot be the depot. Items that are too heavy for a vehicle
have no variables there. Slack exists only for vehicles that as many items could overload, and
spans only the loads that the others leave over, max(0, W - M of all others) .. M[p]. Where L[p]
is 2 or less no slack is needed: each pair of items that is too heavy together is penalised by
itself. For one vehicle all this leaves n x n variables: which item at which step.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from qrobot._arrays import Bools
from qrobot.models.fleet import Vehicles, fleet_of, limits_of
from qrobot.models.layout import VariableLayout, check_size, layered
from qrobot.models.slack import Slack, slack_coefficients
from qrobot.problem import Instance

__all__ = ["anchors", "compact_layout", "paper_layout"]


def paper_layout(
    instance: Instance, encoding: Literal["full", "reduced"], slack: Slack
) -> VariableLayout:
    """Return the variables of an encoding of the paper."""
    fleet = fleet_of(instance, every_robot=True)
    n, robots = instance.size, len(fleet)
    first, last = (0, n + 1) if encoding == "full" else (1, n)
    layers = last - first + 1
    check_size(robots * (n + 1) * layers, encoding)
    return layered(
        encoding,
        fleet,
        n,
        first=first,
        last=np.full(robots, last, dtype=np.int64),
        allowed=[np.ones((layers, n + 1), dtype=np.bool_)] * robots,
        slack=[slack_coefficients(room, slack) for room in fleet.capacities.tolist()],
        summed=np.ones(robots, dtype=np.bool_),
        paired=np.zeros(robots, dtype=np.bool_),
    )


PAIRS = 2
"""Up to this many items a vehicle, capacity is a matter of pairs."""


def compact_layout(
    instance: Instance, slack: Slack, *, break_symmetry: bool = False
) -> VariableLayout:
    """Return the variables of the compact encoding.

    `break_symmetry` keeps only one of the ways in which equal vehicles can exchange their trips.

    Raises
    ------
    InfeasibleError
        When the bounds of items and load already exclude every plan.
    InputError
        When the model is too large.
    """
    fleet = fleet_of(instance)
    n = instance.size
    limits = limits_of(instance, fleet)
    lots = np.concatenate([[0], instance.order_weights[instance.order_of_node[1:]]])
    fitting = np.searchsorted(np.sort(lots[1:]), fleet.capacities, side="right")
    check_size(int((limits.most * (fitting + 1) - limits.least).sum()), "compact")
    paired = limits.binding & (limits.most <= PAIRS)
    summed = limits.binding & ~paired
    allowed = []
    for k in range(len(fleet)):
        nodes: Bools = np.ones((int(limits.most[k]), n + 1), dtype=np.bool_)
        nodes[: int(limits.least[k]), 0] = False
        nodes[:, lots > int(fleet.capacities[k])] = False
        allowed.append(nodes)
    if break_symmetry:
        for group, heaviest in anchors(instance, fleet):
            for r, node in enumerate(heaviest):
                for k in group[r + 1 :]:
                    allowed[k][:, node] = False
    spare = fleet.capacities - limits.lightest
    return layered(
        "compact",
        fleet,
        n,
        first=1,
        last=limits.most,
        allowed=allowed,
        slack=[
            slack_coefficients(int(spare[k]) if summed[k] else 0, slack) for k in range(len(fleet))
        ],
        summed=summed,
        paired=paired,
    )


def anchors(instance: Instance, fleet: Vehicles) -> list[tuple[list[int], list[int]]]:
    """Return groups of equal vehicles, each with the items that tell them apart.

    The r-th anchor, counting from 0, may only be on the first r + 1 vehicles of its group
    (or outside it). Any plan can be relabelled to keep to that: sort each group's trips by
    their first anchor.
    """
    heaviest = (1 + np.argsort(-instance.weights, kind="stable")).tolist()
    found = []
    for room in dict.fromkeys(fleet.capacities.tolist()):
        group = np.flatnonzero(fleet.capacities == room).tolist()
        if len(group) > 1:
            found.append((group, heaviest[: len(group) - 1]))
    return found
