"""What proposals of batches were by themselves, and what repair made of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from qrobot._arrays import Ints

__all__ = ["COMPARED", "Tally", "mean_distance"]

COMPARED = 100
"""Proposals whose distances to each other are measured."""


@dataclass(slots=True)
class Tally:
    """What the proposals of a model were by themselves, and what repair made of them.

    Parameters
    ----------
    variables
        Of the largest model.
    proposals
        How many there were.
    better
        How many are plans shorter than all before, before anything was changed.
    lengths
        Of the proposals that are plans as they are.
    repaired
        Of all that repair made plans of.
    repaired_better
        How many of them are shorter than all before.
    partitions, repaired_partitions
        The first `COMPARED` of each.
    """

    variables: int = 0
    proposals: int = 0
    better: int = 0
    lengths: list[float] = field(default_factory=list)
    repaired: list[float] = field(default_factory=list)
    repaired_better: int = 0
    partitions: list[Ints] = field(default_factory=list)
    repaired_partitions: list[Ints] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return {
            "variables": self.variables,
            "proposals": self.proposals,
            "plans": len(self.lengths),
            "better": self.better,
            "best": min(self.lengths, default=None),
            "mean": float(np.mean(self.lengths)) if self.lengths else None,
            "repaired": len(self.repaired),
            "repaired_better": self.repaired_better,
            "repaired_best": min(self.repaired, default=None),
            "repaired_mean": float(np.mean(self.repaired)) if self.repaired else None,
            "repaired_spread": float(np.std(self.repaired)) if self.repaired else None,
            "diversity": mean_distance(self.partitions),
            "repaired_diversity": mean_distance(self.repaired_partitions),
        }


def mean_distance(partitions: list[Ints]) -> float | None:
    """Return the mean distance of all pairs of partitions, None for fewer than two.

    The distance is the share of pairs of orders on one trip in either that are not in both.
    """
    if len(partitions) < 2:
        return None
    rows, columns = np.triu_indices(partitions[0].size, 1)
    shared = np.array([(p[rows] == p[columns]) & (p[rows] >= 0) for p in partitions], dtype=float)
    both = np.asarray(np.matmul(shared, shared.T))
    sizes = both.diagonal()
    either = np.maximum(sizes[:, None] + sizes[None, :] - both, 1.0)
    return float(1.0 - (both / either)[np.triu_indices(len(partitions), 1)].mean())
