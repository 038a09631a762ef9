"""D-Wave: the annealer and the hybrid solvers of Leap."""
