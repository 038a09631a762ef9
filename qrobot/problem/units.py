"""Weights as whole numbers.

Binary slack variables and exact solvers need integer weights. Decimal input is scaled by
its exact common unit; nothing is ever rounded, so an overloaded trip never looks allowed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from numbers import Rational

import numpy as np
import numpy.typing as npt

from qrobot.errors import InputError

__all__ = ["MAX_UNITS", "Quantity", "common_unit", "exact", "in_units"]

Quantity = float | int | str | Decimal | Fraction
"""What a weight or a capacity may be given as."""

MAX_UNITS = 2**40
"""Largest total weight in units: beyond it the mend is to round the weights."""

MAX_WEIGHT = 10**12
"""Largest weight or capacity, in any unit."""

MAX_DIGITS = 60
"""Most decimals of a number: far more than any scale shows."""

_MEND = "use a plain decimal number"


def exact(value: Quantity, *, field: str) -> Fraction:
    """Return a number as the exact fraction that its decimal notation says.

    Parameters
    ----------
    value
        ``0.1`` means one tenth, not the binary float next to it.
    field
        Path of the field, for the error.

    Raises
    ------
    InputError
        When the value is not a finite number, or huge.
    """
    if isinstance(value, bool):
        raise InputError(f"{value} is not a number", field=field, mend=_MEND)
    if not isinstance(value, Rational):  # numpy's whole numbers are
        value = _decimal(value, field)
    if not -MAX_WEIGHT <= value <= MAX_WEIGHT:
        huge = isinstance(value, Rational) and abs(value) > 10**40  # may be unprintable
        shown = "a number of many digits" if huge else f"{value!s:.40}"
        raise InputError(
            f"{shown} is larger than {MAX_WEIGHT:g} in size",
            field=field,
            mend="use a larger unit of weight",
        )
    return Fraction(value)


def _decimal(value: float | str | Decimal, field: str) -> Decimal:
    try:
        # It gives a float's shortest notation: the one that people wrote.
        number = Decimal(float.__repr__(value) if isinstance(value, float) else value)
    except (ArithmeticError, TypeError, ValueError):
        number = Decimal("NaN")
    exponent = number.as_tuple().exponent
    if not isinstance(exponent, int):  # NaN and infinities have a letter there
        mend = _MEND
        if isinstance(value, str) and re.fullmatch(r"\s*-?\d{1,15},\d{1,15}\s*", value):
            mend = f"write {value.strip().replace(',', '.')}: a point, no comma"
        raise InputError(f"{value!s:.40} is not a finite number", field=field, mend=mend)
    if number and exponent < -MAX_DIGITS:  # 1e-999999999 would be a number of a billion digits
        raise InputError(
            f"{value!s:.40} has more than {MAX_DIGITS} decimals",
            field=field,
            mend="round it up to fewer digits",
        )
    return number


def common_unit(weights: Sequence[Fraction], *, field: str) -> Fraction:
    """Return the greatest common divisor of the weights, as an exact fraction.

    Raises
    ------
    InputError
        When the weights have so many digits that their total exceeds `MAX_UNITS` units.
    """
    positive = [w for w in weights if w > 0]
    if not positive:
        return Fraction(1)
    below = math.lcm(*(w.denominator for w in positive))
    above = math.gcd(*(int(w * below) for w in positive))
    unit = Fraction(above, below)
    if sum(positive) / unit > MAX_UNITS:
        worst = max(positive, key=lambda w: w.denominator)
        raise InputError(
            f"the weights have no common unit of useful size (one is {float(worst)!r})",
            field=f"{field}[].weight",
            mend="round the weights up to fewer digits, for example to grams",
        )
    return unit


def in_units(weights: Sequence[Fraction], unit: Fraction) -> npt.NDArray[np.int64]:
    """Return the weights as whole multiples of the unit, shape (n,)."""
    return np.array([int(w / unit) for w in weights], dtype=np.int64)
