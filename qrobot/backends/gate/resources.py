"""Memory and threads of states.

Threads of OpenMP and BLAS wait for each other by spinning: on a busy machine a state of a few
qubits takes ten times longer on all cores than on one, and gains nothing on an idle one.
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._machine import available_memory
from qrobot.errors import BackendError

__all__ = ["PARALLEL", "aligned", "few_threads", "pair", "readable", "require"]


GAP = 5 << 14
"""Bytes between the two arrays of `pair`."""

LARGEST = 1 << 70
"""Bytes, a thousand EiB; nobody wants to read more than a power of ten of what is larger."""


def require(
    needed: int, what: str, advice: str = "use a smaller model", *, qubits: int | None = None
) -> None:
    """Refuse before allocating when memory is too small.

    Parameters
    ----------
    needed
        Bytes.
    what
        What needs them, with the number of qubits or states: ``"a state of 40 qubits"``.
    advice
        What the user can do about it, as a clause.
    qubits
        Where every qubit doubles the need: how many they are, to say how many would fit.

    Raises
    ------
    BackendError
        When fewer bytes are available.
    """
    room = available_memory()
    if needed > room:
        if qubits is not None:
            fit = next((q for q in range(qubits, 0, -1) if needed >> (qubits - q) <= room), 0)
            advice = f"at most {fit} qubits fit; {advice}"
        raise BackendError(
            f"{what} needs {_counted(needed)} and {_counted(room)} are available; {advice}"
        )


def _counted(count: int) -> str:
    """Return bytes in full and as people read them; beyond `LARGEST` as a power of ten."""
    text = readable(count)
    return text if count >= LARGEST else f"{count:,} bytes ({text})"


def readable(count: int) -> str:
    """Return a number of bytes as people read it: ``1.5 GiB``, or ``10^300 bytes``."""
    size, units = count, ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"]
    if size < 1024:
        return f"{size} bytes"
    if size >= LARGEST:  # too large for a float, or for Python to write down
        return f"10^{int(math.log10(size))} bytes"
    scale = min((size.bit_length() - 1) // 10, len(units) - 1)
    # Whole numbers first: 2**n of many qubits overflows a float.
    return f"{size * 10 // 1024**scale / 10:,.1f} {units[scale]}"


def aligned(count: int, dtype: npt.DTypeLike, *, line: int = 64) -> npt.NDArray[Any]:
    """Return an uninitialised array that begins at a cache line.

    numpy aligns to 16 bytes; vectors of 32 or 64 bytes then cross lines, and the kernels take
    up to four times as long.
    """
    size = np.dtype(dtype).itemsize * count
    raw = np.empty(size + line, dtype=np.uint8)
    start = -raw.ctypes.data % line
    return raw[start : start + size].view(dtype)


def pair(count: int, dtype: npt.DTypeLike) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return two uninitialised arrays that are walked side by side, 80 KiB apart.

    Processors guess the place of a line in the first cache by a hash of its address. Two large
    arrays whose distance is near a power of two, as allocators like to give them, then evict
    each other line by line: measured two to six times slower on 24 and 25 qubits (AMD Zen 4).
    """
    size = np.dtype(dtype).itemsize
    both = aligned(2 * count + GAP // size, dtype, line=4096)
    return both[:count], both[count + GAP // size :]


PARALLEL = 20
"""Qubits from which on more than one thread pays."""


def few_threads(qubits: int) -> AbstractContextManager[object]:
    """Return a context in which numpy, OpenMP and BLAS use one thread for a small state.

    Parameters
    ----------
    qubits
        Of the state; from `PARALLEL` on the libraries decide.
    """
    if qubits >= PARALLEL:
        return nullcontext()
    from threadpoolctl import threadpool_limits

    limited: AbstractContextManager[object] = threadpool_limits(limits=1)
    return limited
