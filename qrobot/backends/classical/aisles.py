"""Whether whole orders in aisles are planned with exact tours, compiled."""

from __future__ import annotations

from qrobot import _jit
from qrobot.problem import AisleWarehouse, Instance
from qrobot.warehouse import MAX_CROSS_AISLES

__all__ = ["takes"]


def takes(instance: Instance) -> bool:
    """Return whether the kernels take an instance: aisles, and numba is installed."""
    warehouse = instance.warehouse
    return (
        isinstance(warehouse, AisleWarehouse)
        and warehouse.blocks < MAX_CROSS_AISLES
        and not warehouse.depot_ways
        and bool(instance.orders)
        and _jit.available()
    )
