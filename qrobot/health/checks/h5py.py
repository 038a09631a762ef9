"""h5py: arrays and attributes into a compressed file in memory, and back."""

import io
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qrobot.health.check import Check

SHAPE, CHUNK = (60, 40), (16, 16)


def data() -> NDArray[np.float64]:
    """Return numbers that no two places share."""
    return np.asarray(np.sqrt(np.arange(float(SHAPE[0] * SHAPE[1]))).reshape(SHAPE))


def checksum(numbers: Any) -> int:
    """Return the CRC-32 of an array's bytes."""
    return zlib.crc32(np.ascontiguousarray(numbers).tobytes())


def answer() -> list[float]:
    """Return the checksums of what was read, whole and sliced, an attribute, and the filter."""
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        made = file.create_dataset(
            "group/roots", data=data(), chunks=CHUNK, compression="gzip", shuffle=True,
            fletcher32=True,
        )  # fmt: skip
        made.attrs["unit"] = "metre"
    with h5py.File(io.BytesIO(memory.getvalue()), "r") as file:
        found = file["group/roots"]
        return [
            checksum(found[...]),
            checksum(found[7:50:3, 11]),
            found.attrs["unit"] == "metre",
            found.compression == "gzip" and found.id.get_storage_size() < data().nbytes,
        ]


def expected() -> list[float]:
    """Return the checksums of what was written."""
    return [checksum(data()), checksum(data()[7:50:3, 11]), 1, 1]


CHECK = Check(
    __name__,
    title="a compressed file, written and read",
    group="science",
    imports=("h5py",),
    source="checksums of what was written",
    tolerance=0.5,  # whole numbers, too large for less
    extra="science",
)
