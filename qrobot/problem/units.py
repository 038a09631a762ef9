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

__all__ = [
    "MAX_UNITS",
    "MAX_WEIGHT",
    "NUMBER",
    "Quantity",
    "common_unit",
    "exact",
    "in_units",
    "number_advice",
]

Quantity = float | int | str | Decimal | Fraction
"""What a weight or a capacity may be given as."""

MAX_UNITS = 2**40
"""Largest total weight in units: beyond it the advice is to round the weights."""

MAX_WEIGHT = 10**12
"""Largest weight or capacity, in any unit."""

MAX_DIGITS = 60
"""Most decimals of a number: far more than any scale shows."""

_ADVICE = "use a plain decimal number"

NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
"""A number in text: ASCII digits, a point, an exponent. Python reads more: ``1_000``, ``nan``."""

_GROUPED = re.compile(r"([-+]?)([1-9][0-9]{0,2})((?:[.,][0-9]{3})+)")
_SPACED = re.compile(r"[\s_'’]")


def exact(value: Quantity, *, field: str) -> Fraction:
    """Return a number as the exact fraction that its decimal notation says.

    ``0.1`` means one tenth, not the binary float next to it. What is not a finite number, or
    huge, is refused; `field` is its path, for the error.
    """
    if isinstance(value, bool):
        raise InputError(f"{value} is not a number", field=field, advice=_ADVICE)
    if not isinstance(value, Rational):  # numpy's whole numbers are
        value = _decimal(value, field)
    if not -MAX_WEIGHT <= value <= MAX_WEIGHT:
        huge = isinstance(value, Rational) and abs(value) > 10**40  # may be unprintable
        shown = "a number of many digits" if huge else f"{value!s:.40}"
        raise InputError(
            f"{shown} is larger than {MAX_WEIGHT:g} in size",
            field=field,
            advice="use a larger unit of weight",
        )
    return Fraction(value)


def number_advice(text: str, mark: str = ".") -> str:
    """Return how a number with grouping marks or another decimal mark should be written."""
    bare = _SPACED.sub("", text)
    if re.fullmatch(r"[-+]?[0-9]{1,30}" if mark == "," else NUMBER, bare):
        return f"write {bare:.40}"
    grouped = _GROUPED.fullmatch(bare)
    if grouped and len(set(re.findall(r"[.,]", bare))) == 1:
        digits = re.sub(r"[.,]", "", bare)
        if len(grouped[3]) > 4:  # several groups: there is one way to read it
            return f"write {digits}"
        return f"write {digits}, or {grouped[1]}{grouped[2]}{mark}{grouped[3][1:]}"
    parts = re.fullmatch(r"([-+]?[0-9][0-9.,]{0,30})[.,]([0-9]{1,30})", bare)
    if parts and not re.search(r"[.,]{2}", bare):
        whole = re.sub(r"[.,]", "", parts[1])
        hint = ": a point, no comma" if mark == "." and len(bare) > len(whole) else ""
        return f"write {whole}{mark}{parts[2]}{hint}"
    return _ADVICE


def _decimal(value: float | str | Decimal, field: str) -> Decimal:
    if isinstance(value, str) and not NUMBER.fullmatch(value.strip()):
        raise InputError(
            f"{value.strip()!s:.40} is not a finite number",
            field=field,
            advice=number_advice(value),
        )
    try:
        # It gives a float's shortest notation: the one that people wrote.
        number = Decimal(float.__repr__(value) if isinstance(value, float) else value)
    except (ArithmeticError, TypeError, ValueError):
        number = Decimal("NaN")
    exponent = number.as_tuple().exponent
    if not isinstance(exponent, int):  # NaN and infinities have a letter there
        raise InputError(f"{value!s:.40} is not a finite number", field=field, advice=_ADVICE)
    if number and exponent < -MAX_DIGITS:  # 1e-999999999 would be a number of a billion digits
        raise InputError(
            f"{value!s:.40} has more than {MAX_DIGITS} decimals",
            field=field,
            advice="round it up to fewer digits",
        )
    return number


def common_unit(weights: Sequence[Fraction], *, field: str) -> Fraction:
    """Return the greatest common divisor of the weights, exactly.

    Weights of so many digits that their total exceeds `MAX_UNITS` units are refused.
    """
    positive = [w for w in weights if w > 0]
    if not positive:
        return Fraction(1)
    below = math.lcm(*(w.denominator for w in positive))
    above = math.gcd(*(int(w * below) for w in positive))
    unit = Fraction(above, below)
    if sum(positive) / unit > MAX_UNITS:
        worst = max(range(len(weights)), key=lambda i: weights[i].denominator)
        raise InputError(
            f"the weights have no common unit of useful size (one is {float(weights[worst])!r})",
            field=f"{field}[{worst}].weight",
            advice="round the weights up to fewer digits, for example to grams",
        )
    return unit


def in_units(weights: Sequence[Fraction], unit: Fraction) -> npt.NDArray[np.int64]:
    """Return the weights as whole multiples of the unit, shape (n,)."""
    return np.array([int(w / unit) for w in weights], dtype=np.int64)
