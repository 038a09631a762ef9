"""The exact planner: all fitting sets, their shortest tours, the best split, the proof."""

from qrobot.backends.classical.exact.packing import no_packing, pack
from qrobot.backends.classical.exact.planner import MAX_ENTRIES, ExactPlanner

__all__ = ["MAX_ENTRIES", "ExactPlanner", "no_packing", "pack"]
