"""Shortest tours through aisle warehouses, and routing policies."""

from qrobot.warehouse.ends import OnCrossAisle
from qrobot.warehouse.one_way import EXACT_STOPS
from qrobot.warehouse.policies import POLICIES, route
from qrobot.warehouse.routing import Router, Tour
from qrobot.warehouse.states import MAX_CROSS_AISLES
from qrobot.warehouse.under_policy import ROUTINGS, PolicyInstance, under_policy
from qrobot.warehouse.walking import Route

__all__ = [
    "EXACT_STOPS",
    "MAX_CROSS_AISLES",
    "POLICIES",
    "ROUTINGS",
    "OnCrossAisle",
    "PolicyInstance",
    "Route",
    "Router",
    "Tour",
    "route",
    "under_policy",
]
