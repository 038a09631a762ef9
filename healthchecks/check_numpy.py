# %% [markdown]
# # numpy: the floor that everything stands on
#
# numpy holds vectors and matrices and hands the hard work to compiled libraries: OpenBLAS for
# linear algebra, pocketfft for Fourier transforms. Every quantum stack here is built on it: a
# state of $n$ qubits is a vector of $2^n$ complex numbers. When a wheel was compiled for a newer
# processor than the robot's, this is where it crashes first.

# %%
import numpy as np

from qrobot.health.checks.numpy import CHECK, SIZE
from qrobot.health.lesson import draw, verdict

chain = 2 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1)
print(chain)

# %% [markdown]
# This matrix is a chain of springs, or the kinetic energy of a particle in a box, on a grid.
# Its eigenvectors are standing waves, $v_k(j) = \sin\frac{\pi k j}{n+1}$, because
# $2\sin a - \sin(a-b) - \sin(a+b) = (2 - 2\cos b)\sin a$. So its eigenvalues are
#
# $$\lambda_k = 2 - 2\cos\frac{\pi k}{n+1}.$$

# %%
values, waves = np.linalg.eigh(chain)
draw(lambda axes: [axes.plot(wave, marker="o") for wave in waves.T[:3]])

# %% [markdown]
# Pushed by one everywhere, $A x = 1$, the chain bends into the parabola $x_k = k(n+1-k)/2$.
# And a cosine that fits three times into 16 samples has one line in its spectrum, of height
# $16/2 = 8$. Eigenvalues, the solution and the spectrum together are the answer:

# %%
names = [f"eigenvalue {k + 1}" for k in range(SIZE)] + [f"bend {k + 1}" for k in range(SIZE)]
verdict(CHECK, names + [f"line {k}" for k in range(9)])

# %% [markdown]
# ## Try it yourself
#
# 1. Join the ends, `chain[0, -1] = chain[-1, 0] = -1`: which eigenvalues come twice, and why?
# 2. Sample a cosine of 3.5 periods. Where did the single line go?
