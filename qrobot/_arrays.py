"""One home for the types of arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Bits", "Bools", "Floats", "Ints", "Reals", "States"]

Bits = npt.NDArray[np.int8]
"""Zeros and ones, or spins."""
Bools = npt.NDArray[np.bool_]
States = npt.NDArray[np.complex128]
"""Complex amplitudes."""
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Reals = npt.NDArray[Any]
"""Of float64 or float32."""
