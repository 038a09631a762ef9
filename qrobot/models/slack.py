"""Slack: how a capacity, an inequality, becomes an equation in binary variables.

load + slack = M, with slack a sum of binaries times whole coefficients. The paper takes
ceil(log2 M) of them with coefficients 1, 2, 4 and so on. That range ends one short of M
when M is a power of two, so an empty robot, or any load below what the range reaches,
pays a penalty that no constraint of the problem asks for. The exact slack takes
floor(log2 M) + 1 binaries and cuts the last coefficient so that the range ends at M.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from qrobot._arrays import Ints

__all__ = ["Slack", "slack_bits", "slack_coefficients"]

Slack = Literal["exact", "paper"]


def slack_coefficients(room: int, kind: Slack = "exact") -> Ints:
    """Return the coefficients of the slack binaries for a range of 0 to `room`, in units.

    ``exact`` reaches `room` and nothing above; ``paper`` has ceil(log2 room) powers of two.
    """
    if room <= 0:
        return np.zeros(0, dtype=np.int64)
    if kind == "paper":
        return 2 ** np.arange((room - 1).bit_length(), dtype=np.int64)
    bits = room.bit_length()
    coefficients = 2 ** np.arange(bits, dtype=np.int64)
    coefficients[-1] = room - (2 ** (bits - 1) - 1)
    return coefficients


def slack_bits(value: int, coefficients: Ints) -> Ints:
    """Return the 0/1 values whose sum of coefficients comes closest to `value` from below.

    The sum equals `value` whenever the range holds it; a value below 0 counts as 0.
    """
    bits = np.zeros(len(coefficients), dtype=np.int64)
    left = value
    # Largest first is exact for powers of two, and for a last coefficient cut smaller.
    for k in np.argsort(-coefficients, kind="stable").tolist():
        if coefficients[k] <= left:
            bits[k] = 1
            left -= int(coefficients[k])
    return bits
