"""Whether rounding left distances that still tell the places apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from qrobot._arrays import Floats

__all__ = ["coarse"]


SMALL = 10.0
"""Largest distances below this lose a twentieth or more to whole numbers."""


def coarse(rounded: Floats, lengths: Callable[[], Floats], rule: str) -> tuple[str, ...]:
    """Return a note when distances are so small that whole numbers hide most of them.

    Parameters
    ----------
    rounded, lengths
        The distances with rounding, and what gives them without.
    rule
        Which of TSPLIB's rules rounded them.
    """
    largest = float(rounded.max(initial=0.0))
    if largest >= SMALL or np.array_equal(rounded, lengths()):
        return ()
    return (
        f"distances are rounded to whole numbers as {rule} demands; the largest is {largest:g} "
        "(rounding none leaves them as they are)",
    )
