# %% [markdown]
# # TensorFlow: a gradient on the tape
#
# TensorFlow is the heaviest wheel of all (1.3 GB installed); the paper's authors built it for an
# hour. A robot uses it for cameras and for learning, not for planning. Its gradient works like
# autograd's: what is computed is recorded on a tape, and the tape is played backwards. It begins
# with a few lines about the processor and about graphics cards that it did not find: no errors.

# %%
import numpy as np
import tensorflow as tf

from qrobot.health.checks.tensorflow import CHECK, INPUTS, TARGETS, WEIGHTS
from qrobot.health.lesson import draw, verdict

weights = tf.Variable(WEIGHTS, dtype="float64")
inputs, targets = tf.constant(INPUTS, dtype="float64"), tf.constant(TARGETS, dtype="float64")


def loss_and_slope():
    """Return how far a layer of tanh misses its targets, and the gradient of its weights."""
    with tf.GradientTape() as tape:
        loss = tf.reduce_sum((tf.tanh(inputs @ weights) - targets) ** 2)
    return loss, tape.gradient(loss, weights)


print(loss_and_slope()[1].numpy().round(4))

# %% [markdown]
# ## The same by hand
#
# With $Y = \tanh(XW)$ and $L = \sum (Y - T)^2$, the chain rule gives
#
# $$\frac{\partial L}{\partial W} = X^T \left( 2\,(Y - T) \odot (1 - Y^2) \right),$$
#
# because $\tanh' = 1 - \tanh^2$. Three lines of numpy, and the check's expected answer.
#
# ## Downhill

# %%
before, curve = weights.numpy(), []
for _ in range(60):
    loss, slope = loss_and_slope()
    curve.append(float(loss))
    weights.assign_sub(0.2 * slope)
print("loss", curve[0], "->", curve[-1], " largest step:", np.abs(weights.numpy() - before).max())
draw(lambda axes: axes.semilogy(curve))

# %% [markdown]
# ## The check
#
# Loss and gradient twice: *eager*, step by step, and as a graph that `tf.function` compiles. The
# two take different ways through the library, and both must agree with the chain rule.

# %%
slopes = [f"slope {row}{column}" for row in range(3) for column in range(2)]
labels = [f"{kind}: {name}" for kind in ("eager", "graph") for name in ("loss", *slopes)]
verdict(CHECK, labels)

# %% [markdown]
# ## Try it yourself
#
# 1. Put a `print("traced")` into a `tf.function`. How often does it print in ten calls?
# 2. Use `float32`. Which tolerance would the check need?
