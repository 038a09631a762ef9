"""TensorFlow: a gradient by tape, eager and as a compiled graph."""

from typing import Any

import numpy as np

from qrobot.health.check import Check

WEIGHTS = ((0.3, -0.8), (1.1, 0.4), (-0.5, 0.9))
INPUTS = ((0.2, 0.7, -0.4), (1.0, -0.3, 0.6))
TARGETS = ((0.1, -0.2), (0.5, 0.3))


def answer() -> list[float]:
    """Return the loss of a layer of tanh and the gradient of its weights, both ways."""
    import tensorflow

    weights = tensorflow.Variable(WEIGHTS, dtype="float64")
    inputs = tensorflow.constant(INPUTS, dtype="float64")
    targets = tensorflow.constant(TARGETS, dtype="float64")

    def step() -> Any:
        with tensorflow.GradientTape() as tape:
            miss = tensorflow.tanh(inputs @ weights) - targets
            loss = tensorflow.reduce_sum(miss**2)
        return loss, tape.gradient(loss, weights)

    numbers: list[float] = []
    for run in (step, tensorflow.function(step)):
        loss, slope = run()
        numbers += [float(loss), *slope.numpy().ravel().tolist()]
    return numbers


def expected() -> list[float]:
    """Return them by the chain rule, twice."""
    inputs = np.array(INPUTS)
    out = np.tanh(inputs @ np.array(WEIGHTS))
    miss = out - np.array(TARGETS)
    slope = inputs.T @ (2 * miss * (1 - out**2))
    return [float((miss**2).sum()), *slope.ravel().tolist()] * 2


CHECK = Check(
    __name__,
    title="a gradient, eager and compiled",
    group="science",
    imports=("tensorflow",),
    source="the chain rule, in numpy",
    extra="science",
)
