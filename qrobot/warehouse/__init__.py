"""Shortest tours through aisle warehouses, and routing policies."""

from qrobot.warehouse.routing import Router, Tour
from qrobot.warehouse.states import MAX_CROSS_AISLES

__all__ = ["MAX_CROSS_AISLES", "Router", "Tour"]
