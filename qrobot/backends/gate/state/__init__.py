"""States of the gate model by exact simulation: diagonal QAOA, a subspace, any circuit."""
