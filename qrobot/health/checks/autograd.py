"""autograd: first and second derivatives of a function with a known form."""

import math
from typing import Any

from qrobot.health.check import Check

POINT = 0.8


def answer() -> list[float]:
    """Return the first two derivatives of ``sin(x) exp(-x**2)``."""
    import autograd
    from autograd import numpy

    def curve(x: Any) -> Any:
        return numpy.sin(x) * numpy.exp(-(x**2))

    slope = autograd.grad(curve)
    return [float(slope(POINT)), float(autograd.grad(slope)(POINT))]


def expected() -> list[float]:
    """Return them by the product rule."""
    x, bell = POINT, math.exp(-(POINT**2))
    sine, cosine = math.sin(x), math.cos(x)
    return [(cosine - 2 * x * sine) * bell, ((4 * x * x - 3) * sine - 4 * x * cosine) * bell]


CHECK = Check(
    __name__,
    title="first and second derivative",
    group="gate model",
    imports=("autograd", "autograd.numpy"),
    distributions=("autograd",),
    source="the product rule",
    extra="pennylane",
)
