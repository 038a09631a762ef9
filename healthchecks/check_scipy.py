# %% [markdown]
# # scipy: what numpy leaves out
#
# scipy adds sparse matrices, optimisers and special functions. Qiskit, PennyLane and dimod's
# neighbours all call it: VQE turns its angles by `scipy.optimize`, a simulator evolves a state
# by a matrix exponential, and exact solvers take the lowest eigenvalue of a sparse Hamiltonian
# from ARPACK, which is Fortran.

# %%
import numpy as np
from scipy.linalg import expm
from scipy.optimize import linear_sum_assignment

from qrobot.health.checks.scipy import ANGLE, CHECK, COSTS, SIZE
from qrobot.health.lesson import table, verdict

# %% [markdown]
# ## A rotation grows out of its generator
#
# For $G = \begin{pmatrix}0 & -1\\ 1 & 0\end{pmatrix}$ the squares alternate, $G^2 = -1$, and the
# series sorts itself into $e^{tG} = \cos t + G \sin t$. Term by term:

# %%
generator = np.array([[0.0, -ANGLE], [ANGLE, 0.0]])
term, partial, rows = np.eye(2), np.zeros((2, 2)), []
for k in range(1, 9):
    partial = partial + term
    term = term @ generator / k
    rows.append((k, partial[0, 0], np.abs(partial - expm(generator)).max()))
table(["terms", "cos 0.7 so far", "error"], rows)

# %% [markdown]
# ## Who does which job
#
# Four jobs, four robots, a cost for each pair: the assignment of least cost. Brute force looks at
# $4! = 24$ permutations, the Hungarian method needs of the order of $n^3$ steps.

# %%
robots, jobs = linear_sum_assignment(np.array(COSTS))
table(
    ["robot", "job", "cost"],
    [(int(r), int(j), COSTS[r][j]) for r, j in zip(robots, jobs, strict=True)],
)

# %% [markdown]
# ## The check
#
# The rotation against sine and cosine; the two largest eigenvalues of a chain of 40 springs
# (sparse) against $2 - 2\cos\frac{k\pi}{41}$; the least cost against all 24 permutations.

# %%
rotation = ["cos", "-sin", "sin", "cos"]
verdict(CHECK, [*rotation, f"eigenvalue {SIZE - 1}", f"eigenvalue {SIZE}", "least cost"])

# %% [markdown]
# ## Try it yourself
#
# 1. How many terms does the series need for an angle of 30? Why does `expm` halve the matrix
#    first and square the result afterwards?
# 2. Make one cost negative. Does the method still work?
