# %% [markdown]
# # autograd: derivatives without algebra
#
# autograd runs a function written in numpy, remembers every step, and applies the chain rule
# backwards. PennyLane uses it to turn the knobs of a quantum circuit downhill.

# %%
import autograd
import autograd.numpy as anp
import numpy as np

from qrobot.health.checks.autograd import CHECK, POINT
from qrobot.health.lesson import draw, table, verdict


def curve(x):
    """Return a wave in a bell."""
    return anp.sin(x) * anp.exp(-(x**2))


slope = autograd.grad(curve)
grid = np.linspace(-2.5, 2.5, 101)
draw(lambda axes: axes.plot(grid, curve(grid), grid, [slope(x) for x in grid]))

# %% [markdown]
# ## Why not just subtract?
#
# The difference quotient $\frac{f(x+h) - f(x-h)}{2h}$ has an error of the order of $h^2$, so a
# small $h$ seems better. But subtracting nearly equal numbers loses digits, of the order of
# $10^{-16}/h$. There is a best $h$, and it costs half of the digits. autograd has no $h$.

# %%
exact = slope(POINT)
steps = [10.0**-k for k in range(1, 13)]
errors = [abs((curve(POINT + h) - curve(POINT - h)) / (2 * h) - exact) for h in steps]
table(["h", "error"], list(zip(steps, errors, strict=True)))

# %% [markdown]
# ## The check
#
# By the product rule, for $f(x) = \sin x\, e^{-x^2}$,
#
# $$f' = (\cos x - 2x \sin x)\,e^{-x^2}, \qquad
# f'' = \left((4x^2 - 3)\sin x - 4x\cos x\right)e^{-x^2}.$$
#
# The second derivative is autograd applied to its own result.

# %%
verdict(CHECK, ["f'", "f''"])

# %% [markdown]
# ## Try it yourself
#
# 1. Work out $f'''(0)$ by hand and let autograd confirm it.
# 2. Put an `if x > 0:` into the curve. What is the slope at the corner?
