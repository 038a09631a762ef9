"""Parts of the question that column generation splits, and what is proven."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot.backends.classical.generation.batches import Pool
from qrobot.backends.classical.generation.master import Pairs
from qrobot.backends.classical.orders import Batch

__all__ = ["Part", "Proof", "Rows", "gain"]

Rows = npt.NDArray[np.intp]


@dataclass(slots=True)
class Proof:
    """What is known.

    Parameters
    ----------
    bound
        Every plan costs at least this: metres, with the price of trips.
    plan
        The orders of each batch of a plan that costs less than the one given; None without.
    complete
        Whether the plan found, or the one given, is proven to be best.
    programmes, work
        Linear programmes solved, and units of work done.
    """

    bound: float = 0.0
    plan: list[Batch] | None = None
    complete: bool = False
    programmes: int = 0
    work: int = 0


@dataclass(slots=True)
class Part:
    """A part of the question.

    Parameters
    ----------
    bound
        No plan of this part costs less.
    trips
        Least and most trips.
    together, apart
        Pairs of orders that share a trip, and that do not.
    pool, rows
        Listed batches, and which of them plans of this part may hold; None: not listed.
    started
        Whether its linear programme was solved once, without cuts.
    estimate
        What the linear programme costs before all batches were priced: no bound.
    """

    bound: float
    trips: tuple[int, int]
    together: Pairs = ()
    apart: Pairs = ()
    pool: Pool | None = None
    rows: Rows | None = None
    started: bool = False
    estimate: float = 0.0


def gain(pieces: list[Part]) -> float:
    """Return how much a split raises both estimates, as their product."""
    return math.prod(max(piece.estimate - piece.bound, 1e-3) for piece in pieces)
