"""numpy: eigenvalues, a linear system and a Fourier transform with closed forms."""

import math

from qrobot.health.check import Check

SIZE = 6


def answer() -> list[float]:
    """Return eigenvalues of the chain, its inverse applied to ones, and a spectral line."""
    import numpy as np

    chain = 2 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1)
    wave = np.cos(2 * np.pi * 3 * np.arange(16) / 16)
    return [
        *np.linalg.eigvalsh(chain).tolist(),
        *np.linalg.solve(chain, np.ones(SIZE)).tolist(),
        *np.abs(np.fft.rfft(wave)).tolist(),
    ]


def expected() -> list[float]:
    """Return the same by formula."""
    return [
        *(2 - 2 * math.cos(k * math.pi / (SIZE + 1)) for k in range(1, SIZE + 1)),
        *(k * (SIZE + 1 - k) / 2 for k in range(1, SIZE + 1)),
        *(8.0 if k == 3 else 0.0 for k in range(9)),
    ]


CHECK = Check(
    __name__,
    title="linear algebra and FFT",
    group="base",
    imports=("numpy", "numpy.linalg", "numpy.fft"),
    distributions=("numpy",),
    source="closed forms of the discrete Laplacian and of a cosine's spectrum",
    quick=True,
)
