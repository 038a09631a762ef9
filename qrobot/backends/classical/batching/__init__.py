"""The batching search: ruin and recreate over whole orders."""

from qrobot.backends.classical.batching.planner import BatchingPlanner, begin, polished
from qrobot.backends.classical.batching.ruin import Batches, Yard
from qrobot.backends.classical.batching.tour import improve_tour, tour_length

__all__ = ["Batches", "BatchingPlanner", "Yard", "begin", "improve_tour", "polished", "tour_length"]
