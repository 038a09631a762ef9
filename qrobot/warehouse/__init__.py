"""Shortest tours through aisle warehouses, and routing policies."""

from qrobot.warehouse.routing import Router, Tour

__all__ = ["Router", "Tour"]
