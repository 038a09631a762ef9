"""Numbers as people read them, the same in tables, sentences and pictures."""

from __future__ import annotations

from fractions import Fraction

__all__ = ["number"]


def number(value: float | Fraction) -> str:
    """Return a number with as many digits as people want to read.

    >>> [number(v) for v in (277, 277.000001, 12.5, 1234.567, 0.0123456, 98765.4)]
    ['277', '277', '12.5', '1234.57', '0.0123', '98765']
    """
    value = float(value) + 0.0  # never "-0"
    if abs(value) < 1 and value != 0:
        return f"{value:.3g}"
    text = f"{value:.0f}" if abs(value) >= 10_000 else f"{value:.2f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
