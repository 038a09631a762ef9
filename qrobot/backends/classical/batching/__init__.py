"""The batching search: ruin and recreate over whole orders."""

from qrobot.backends.classical.batching.planner import (
    BatchingPlanner,
    batches_of,
    ruin_and_recreate,
)
from qrobot.backends.classical.batching.ruin import Batches, SearchData
from qrobot.backends.classical.batching.tour import improve_tour, tour_length

__all__ = [
    "Batches",
    "BatchingPlanner",
    "SearchData",
    "batches_of",
    "improve_tour",
    "ruin_and_recreate",
    "tour_length",
]
