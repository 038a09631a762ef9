"""Questions in which every trip is walked by a routing policy."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Place, Slot
from qrobot.warehouse.policies import check_layout, route
from qrobot.warehouse.walking import Route

__all__ = ["ROUTINGS", "PolicyInstance", "under_policy"]

ROUTINGS = (
    "exact", "s-shape", "return", "midpoint", "largest-gap", "combined", "aisle-by-aisle",
)  # fmt: skip
"""How trips may be walked: by shortest tours, or by a policy."""


@dataclass(frozen=True, repr=False)
class PolicyInstance(Instance):
    """An instance whose trips are walked by a policy: their lengths are those of its ways.

    Parameters
    ----------
    policy
        One of `ROUTINGS`.
    """

    policy: str = "s-shape"

    @property
    def routing(self) -> str:
        """How trips are walked."""
        return self.policy

    @cached_property
    def _ways(self) -> dict[frozenset[Place], Route]:
        return {}

    def _way(self, nodes: Sequence[int]) -> tuple[list[Slot], Route]:
        """Return the places of a trip, each once, and the way past them."""
        assert isinstance(self.warehouse, AisleWarehouse)
        places = {self.items[v - 1].place for v in nodes}
        slots = sorted(
            (place for place in places if isinstance(place, Slot)),
            key=lambda slot: (slot.aisle, slot.block, slot.slot, slot.side),
        )
        known = frozenset(places)
        if known not in self._ways:
            self._ways[known] = route(self.warehouse, slots, self.policy)
        return slots, self._ways[known]

    def route_length(self, route: Sequence[int]) -> float:
        """Return the length of the policy's way past the nodes, in whatever sequence, metres."""
        return self._way(route)[1].length if len(route) else 0.0

    def in_sequence(self, routes: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return the nodes of each trip as the policy passes them."""
        ordered = []
        for nodes in routes:
            slots, way = self._way(nodes)
            rank: dict[Place, int] = {slots[i]: k for k, i in enumerate(way.sequence)}
            passed = [(rank[self.items[v - 1].place], v) for v in nodes]
            ordered.append([v for _, v in sorted(passed)])
        return ordered


def under_policy(instance: Instance, routing: str) -> Instance:
    """Return the question in which every trip is walked by a policy.

    Raises
    ------
    InputError
        When there is no such routing, or it says nothing about the warehouse.
    """
    if routing not in ROUTINGS:
        raise InputError(
            f"{routing!r} is not a routing",
            field="routing",
            advice=f"use one of {', '.join(ROUTINGS)}",
        )
    if routing == "exact":
        return instance
    warehouse = instance.warehouse
    reason = ""
    if not isinstance(warehouse, AisleWarehouse):
        reason = "is a policy for aisles, this warehouse has none"
    else:
        reason = check_layout(warehouse, routing)
    if reason:
        raise InputError(
            f"{routing!r} {reason}", field="routing", advice="leave the routing out: use exact"
        )
    fields = {f.name: getattr(instance, f.name) for f in dataclasses.fields(Instance)}
    return PolicyInstance(**fields, policy=routing)
