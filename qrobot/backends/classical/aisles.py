"""Whether whole orders in aisles are planned by the compiled kernels, with exact tours."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from qrobot import _jit
from qrobot._machine import slowdown
from qrobot.backends.base import Stop
from qrobot.problem import AisleWarehouse, Instance
from qrobot.warehouse import MAX_CROSS_AISLES

__all__ = ["NOT_COMPILED", "PLACES", "TOURS", "compiled_soon", "is_late", "takes"]

COMPILING = 120.0
"""Seconds that compiling may take on a small robot: with less time, only cached kernels run."""

LOADING = 1.5
"""Seconds that loading numba and the kernels may take by themselves: with less time, another search
runs."""

NOT_COMPILED = (
    "the search with exact tours is not compiled yet, so a slower one ran: "
    "`qrobot compile` does it once for this machine"
)

KERNELS = (("batching/annealing.py", "_anneal"), ("generation/batches.py", "_list_batches"))
"""Of searches for batches: file and function."""

PLACES = (
    ("../../warehouse/labels.py", "_label"),
    ("../../warehouse/subgradient.py", "search_prices"),
)
"""Of the choice of places."""

TOURS = (("../../warehouse/kernels.py", "_tour_length"),)
"""Of shortest tours alone."""


def takes(instance: Instance) -> bool:
    """Return whether the kernels take an instance: aisles walked both ways, and numba is there."""
    warehouse = instance.warehouse
    return (
        isinstance(warehouse, AisleWarehouse)
        and warehouse.blocks < MAX_CROSS_AISLES
        and not warehouse.is_one_way
        and bool(instance.orders)
        and _jit.available()
    )


def is_late(stop: Stop) -> bool:
    """Return whether the time that is left would go into loading the kernels."""
    return stop.remaining < LOADING * slowdown()


def compiled_soon(stop: Stop, kernels: Sequence[tuple[str, str]] = KERNELS) -> bool:
    """Return whether kernels are in numba's cache, or may be compiled now.

    They may where the time allows it, unless the environment says ``QROBOT_COMPILE=0``: in
    containers, whose caches end with them.
    """
    if "numba" not in sys.modules and is_late(stop):
        return False
    if stop.remaining >= COMPILING and os.environ.get("QROBOT_COMPILE") != "0":
        return True
    here = Path(__file__).parent
    return all(_jit.is_cached(here / file, name) for file, name in kernels)
