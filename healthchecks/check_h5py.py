# %% [markdown]
# # h5py: arrays on the disk
#
# HDF5 is a file that holds folders of arrays, with compression, checksums and notes. PySCF keeps
# its integrals in it and Keras its weights. h5py speaks to the C library; a wheel carries its own
# copy, and zlib with it, which is what could be broken on another processor.

# %%
import io

import h5py
import numpy as np

from qrobot.health.checks.h5py import CHECK, CHUNK, data
from qrobot.health.lesson import table, verdict

# %% [markdown]
# ## Why shuffle?
#
# An array is stored in chunks, and each chunk is compressed by itself: a slice needs only the
# chunks that it touches. Neighbouring doubles differ in their last bytes and agree in the first.
# *Shuffle* puts all first bytes together, then all second ones, and so on: long runs of equal
# bytes, which gzip likes. Nothing is lost; it only changes the sequence of bytes.

# %%
rows = []
for name, options in {
    "plain": {},
    "gzip": {"compression": "gzip"},
    "shuffle, then gzip": {"compression": "gzip", "shuffle": True},
}.items():
    with h5py.File(io.BytesIO(), "w") as file:
        made = file.create_dataset("roots", data=data(), chunks=CHUNK, **options)
        file.flush()
        rows.append((name, made.id.get_storage_size(), bool(np.array_equal(made[...], data()))))
table(["how", "bytes", "the same numbers"], rows)
print("one slice touches few chunks:", data()[7:50:3, 11].round(2)[:4], "...")

# %% [markdown]
# ## The check
#
# An array and an attribute are written into memory and read again. The checksum (CRC-32, from
# Python's own zlib) of every byte must be the same, whole and in a slice; the attribute must be
# there, and the data must have been compressed.

# %%
verdict(CHECK, ["checksum", "checksum of a slice", "attribute", "compressed"])

# %% [markdown]
# ## Try it yourself
#
# 1. Store random numbers instead of roots. What does gzip gain now, and why?
# 2. Flip one byte of the file by hand. Which of `fletcher32=True` and `False` notices?
