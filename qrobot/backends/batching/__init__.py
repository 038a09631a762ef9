"""The batching search: ruin and recreate over whole orders."""

from qrobot.backends.batching.planner import BatchingPlanner, begin
from qrobot.backends.batching.ruin import Batches, Yard
from qrobot.backends.batching.tour import improve_tour, tour_length

__all__ = ["Batches", "BatchingPlanner", "Yard", "begin", "improve_tour", "tour_length"]
