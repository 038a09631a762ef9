# %% [markdown]
# # LiteRT: a trained network on a small machine
#
# LiteRT (once TensorFlow Lite) only runs networks that were trained elsewhere. It is a fraction of
# TensorFlow's size, reads a `.tflite` file and hands the sums to XNNPACK, which is written for each
# kind of processor, so also for the robot's; it says so when it starts.

# %%
import base64

import numpy as np
from ai_edge_litert.interpreter import Interpreter

from qrobot.health.checks.litert import BIAS, CHECK, INPUTS, NETWORK, WEIGHTS
from qrobot.health.lesson import draw, table, verdict

content = base64.b64decode(NETWORK)
network = Interpreter(model_content=content, num_threads=1)
network.allocate_tensors()
print(len(content), "bytes; letters 5 to 8 of every such file:", content[4:8].decode())
table(
    ["tensor", "shape", "kind"],
    [
        (tensor["name"], str(tensor["shape"].tolist()), tensor["dtype"].__name__)
        for tensor in network.get_tensor_details()
    ],
)

# %% [markdown]
# ## What it computes
#
# Two layers: $h = \max(0, W x + b)$ and $y = \sigma(V h + c)$ with $\sigma(z) = 1/(1 + e^{-z})$. A
# unit of the first layer is silent where its sum is negative:

# %%
hidden = np.maximum(np.array(INPUTS) @ np.array(WEIGHTS).T + np.array(BIAS), 0)
table(
    ["input", *(f"h{k}" for k in range(len(BIAS)))],
    [(str(x), *map(float, row)) for x, row in zip(INPUTS, hidden, strict=True)],
)

# %% [markdown]
# Along a line of inputs the first layer is made of straight pieces, and the logistic function
# bends them between 0 and 1:

# %%
(source,), (target,) = network.get_input_details(), network.get_output_details()
grid, outs = np.linspace(-3, 3, 121), []
for x in grid:
    network.set_tensor(source["index"], np.array([[x, 0.4, 0.2]], dtype=np.float32))
    network.invoke()
    outs.append(network.get_tensor(target["index"])[0].copy())
draw(lambda axes: axes.plot(grid, outs))

# %% [markdown]
# ## The check
#
# Two outputs for each of three inputs, against the two formulas in numpy. The network counts in 32
# bits, numpy in 64: the tolerance is $10^{-5}$.

# %%
verdict(CHECK, [f"output {k} of {x}" for x in INPUTS for k in range(2)])

# %% [markdown]
# ## Try it yourself
#
# 1. Leave out `.copy()` above. What does the picture show, and whose memory is it?
# 2. Find the corners of the curve in the picture by hand: where does a sum of $Wx + b$ change sign?
