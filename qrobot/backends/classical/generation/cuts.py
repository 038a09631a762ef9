"""Rank-1 cuts of a set partition. Importing this module imports numba.

The rows of some orders are added up with a multiplier each and rounded down: of the batches, each
counted as often as the whole part of the sum of its orders' multipliers, at most the whole part of
the sum of all can be chosen. With three rows and halves these are the subset-row cuts of Jepsen et
al. (2008); more rows and other multipliers after Pecin et al. (2017).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot._jit import compile_kernel

__all__ = ["Cut", "violated_cuts"]

KINDS = (
    ((1, 1, 1), 2),
    ((1, 1, 1, 1, 1), 2),
    ((1, 1, 1, 1, 1), 3),
    ((2, 1, 1, 1), 3),
    ((2, 2, 1, 1, 1), 4),
    ((3, 1, 1, 1, 1), 4),
    ((3, 2, 2, 1, 1), 5),
    ((2, 2, 1, 1, 1), 3),
)
"""Multipliers of the rows, and what they are divided by."""

STARTS = 120
"""Sets of orders from which cuts of each kind are sought."""


@dataclass(frozen=True, slots=True)
class Cut:
    """A cut.

    Parameters
    ----------
    orders
        Whose rows are added.
    multipliers, divisor
        With which whole multiplier each, and what the sum is divided by.
    """

    orders: tuple[int, ...]
    multipliers: tuple[int, ...]
    divisor: int

    @property
    def most(self) -> int:
        """The right-hand side."""
        return sum(self.multipliers) // self.divisor

    def counts(self, batch: tuple[int, ...]) -> int:
        """Return how often a batch counts."""
        of = zip(self.orders, self.multipliers, strict=True)
        return sum(m for order, m in of if order in batch) // self.divisor


def _climb(
    member: npt.NDArray[np.int64],
    shares: Floats,
    sets: Ints,
    multipliers: Ints,
    divisor: int,
    found: Floats,
) -> None:
    """Exchange single orders of each set as long as that raises what its cut counts."""
    rows, count = member.shape
    total = np.empty(rows, dtype=np.int64)
    for at in range(len(sets)):
        chosen = sets[at]
        total[:] = 0
        for k in range(len(multipliers)):
            total += multipliers[k] * member[:, chosen[k]]
        value = 0.0
        for row in range(rows):
            value += shares[row] * (total[row] // divisor)
        better = True
        while better:
            better = False
            for k in range(len(multipliers)):
                total -= multipliers[k] * member[:, chosen[k]]
                best, best_value = chosen[k], value
                for order in range(count):
                    taken = False
                    for other in range(len(multipliers)):
                        taken |= chosen[other] == order
                    if taken:
                        continue
                    trial = 0.0
                    for row in range(rows):
                        trial += shares[row] * (
                            (total[row] + multipliers[k] * member[row, order]) // divisor
                        )
                    if trial > best_value + 1e-9:
                        best, best_value = order, trial
                if best != chosen[k]:
                    chosen[k], value, better = best, best_value, True
                total += multipliers[k] * member[:, chosen[k]]
        found[at] = value


_climb = compile_kernel(_climb)


def violated_cuts(
    batches: list[tuple[int, ...]],
    shares: Floats,
    orders: int,
    most: int,
    violation: float,
    known: set[Cut],
    random: np.random.Generator,
) -> list[Cut]:
    """Return the most violated cuts that are found, the most violated first.

    Parameters
    ----------
    batches, shares
        A solution of the linear programme.
    orders
        How many.
    most
        How many cuts to return.
    violation
        By how much they must be violated.
    known
        Cuts that are there already.
    random
        Where the search begins.
    """
    member = np.zeros((len(batches), orders), dtype=np.int64)
    for row, batch in enumerate(batches):
        member[row, list(batch)] = 1
    fractional = [b for b, share in zip(batches, shares, strict=True) if share < 1 - 1e-6]
    best: dict[Cut, float] = {}
    for multipliers, divisor in KINDS:
        size = len(multipliers)
        if not fractional or size > orders:
            continue
        sets = np.array([_start(fractional, size, orders, random) for _ in range(STARTS)])
        found = np.zeros(len(sets))
        _climb(member, shares, sets, np.array(multipliers), divisor, found)
        for row, value in zip(sets.tolist(), found.tolist(), strict=True):
            # One name for each cut: orders of equal multiplier in rising sequence.
            terms = sorted(zip(multipliers, row, strict=True), key=lambda t: (-t[0], t[1]))
            cut = Cut(tuple(o for _, o in terms), tuple(m for m, _ in terms), divisor)
            if value > cut.most + violation and cut not in known:
                best[cut] = value - cut.most
    return sorted(best, key=lambda cut: -best[cut])[:most]


def _start(
    batches: list[tuple[int, ...]], size: int, orders: int, random: np.random.Generator
) -> list[int]:
    """Return a set of orders, the first of them from fractional batches that share one."""
    first = batches[int(random.integers(len(batches)))]
    meets = [b for b in batches if b is not first and set(b) & set(first)] or [first]
    other = meets[int(random.integers(len(meets)))]
    likely = random.permutation(list({*first, *other})).tolist()
    rest = random.permutation(orders).tolist()
    return list(dict.fromkeys([*likely, *rest]))[:size]
