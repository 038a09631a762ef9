"""numba: machine code made for this processor."""

from qrobot.health.check import Check

COUNT = 1000


def answer() -> list[float]:
    """Return sums of squares, and of roots' squares, by a compiled loop."""
    import numba

    @numba.njit  # type: ignore[untyped-decorator]
    def sums(count: int) -> tuple[float, float]:
        squares = roots = 0.0
        for k in range(count):
            squares += k * k
            roots += (k**0.5) ** 2
        return squares, roots

    return list(sums(COUNT))


def expected() -> list[float]:
    """Return the closed forms."""
    n = COUNT
    return [(n - 1) * n * (2 * n - 1) / 6, (n - 1) * n / 2]


CHECK = Check(
    __name__,
    title="a compiled loop",
    group="gate model",
    imports=("numba",),
    distributions=("numba", "llvmlite"),
    source="closed forms of the sums",
    tolerance=1e-6,
    extra="braket",
)
