# %% [markdown]
# # Qiskit Machine Learning: likeness as overlap
#
# A kernel says how alike two points are; a support vector machine needs nothing else. A quantum
# kernel turns each point into a state and takes their overlap,
# $k(x, y) = |\langle\phi(x)|\phi(y)\rangle|^2$. In 2021 the paper could not install this package;
# today it is an ordinary wheel.

# %%
import numpy as np
from qiskit.circuit.library import z_feature_map
from qiskit_machine_learning.kernels import FidelityStatevectorKernel

from qrobot.health.checks.qiskit_machine_learning import CHECK, POINTS
from qrobot.health.lesson import draw, table, verdict

features = z_feature_map(2, reps=1)
print(features.draw("text"))

# %% [markdown]
# A Hadamard, then a phase of $2x$: one qubit for each number, and no entanglement. One qubit gives
# $\frac{|0\rangle + e^{2ix}|1\rangle}{\sqrt2}$, and the overlap of two of these is
# $\left|\frac{1 + e^{2i(y-x)}}{2}\right|^2 = \cos^2(x - y)$. Qubits multiply:
#
# $$k(x, y) = \prod_i \cos^2(x_i - y_i).$$

# %%
kernel = FidelityStatevectorKernel(feature_map=features)
grid = np.linspace(-np.pi, np.pi, 61)
likeness = kernel.evaluate(np.array([[x, 0.0] for x in grid]), np.array([[0.0, 0.0]])).ravel()
draw(lambda axes: axes.plot(grid, likeness))
matrix = kernel.evaluate(np.array(POINTS))
table(
    ["", *map(str, POINTS)],
    [(str(point), *map(float, row)) for point, row in zip(POINTS, matrix, strict=True)],
)

# %% [markdown]
# The curve has the period $\pi$: to this map a number and the number plus $\pi$ are the same. Data
# must be scaled first. And since the kernel is a product of cosines, a laptop computes it, too: a
# map without entanglement gives no quantum advantage.
#
# ## The check
#
# The matrix by state vectors against the formula. Then by circuits and shots: prepare $x$, undo
# $y$, count the zeros. For equal points every shot must say zero, so that is asked exactly; for
# other pairs shots scatter.

# %%
pairs = [f"k({a}, {b})" for a in range(len(POINTS)) for b in range(len(POINTS))]
verdict(CHECK, [*pairs, *(f"by shots, point {a}" for a in range(len(POINTS)))])

# %% [markdown]
# ## Try it yourself
#
# 1. Take `zz_feature_map`: the points now meet in a phase of their own. Is the kernel still a
#    product?
# 2. How many shots does an overlap of 0.01 need before it can be distinguished from zero?
