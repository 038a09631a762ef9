# %% [markdown]
# # Qiskit Finance: a portfolio is a packing with nerves
#
# Which of three papers to buy, when two are wanted? Wanted are high returns and little risk, and
# risk is a square: papers that rise and fall together are worse than each alone. So the question is
# quadratic in bits by itself, and maps to couplings without tricks.

# %%
import itertools

import numpy as np
from qiskit.quantum_info import Statevector
from qiskit_finance.circuit.library import NormalDistribution

from qrobot.health.checks.qiskit_finance import (
    BOUNDS,
    BUDGET,
    CHECK,
    COVARIANCES,
    MEAN,
    PENALTY,
    QUBITS,
    RETURNS,
    RISK,
    VARIANCE,
)
from qrobot.health.lesson import draw, table, verdict

# %% [markdown]
# $$E(x) = q\, x^T \Sigma x - \mu^T x + P\,(\textstyle\sum_i x_i - B)^2$$
#
# with returns $\mu$, covariances $\Sigma$, a taste for risk $q$, a budget $B$ and a penalty $P$:

# %%
rows = []
for bits in itertools.product((0, 1), repeat=len(RETURNS)):
    x = np.array(bits)
    risk, gain = float(x @ np.array(COVARIANCES) @ x), float(x @ np.array(RETURNS))
    miss = int(x.sum()) - BUDGET
    rows.append((str(bits), gain, risk, miss, RISK * risk - gain + PENALTY * miss**2))
table(["portfolio", "return", "risk", "off budget", "energy"], rows)

# %% [markdown]
# Papers 0 and 2 move against one another (covariance -0.02): together they carry less risk.
#
# ## A bell in amplitudes
#
# For prices a quantum computer loads a distribution: state $k$ gets the probability of its price.
# Three qubits hold eight prices.

# %%
bell = NormalDistribution(QUBITS, mu=MEAN, sigma=VARIANCE, bounds=BOUNDS)
prices = np.linspace(*BOUNDS, 2**QUBITS)
draw(lambda axes: axes.bar(prices, Statevector(bell).probabilities(), width=0.2))

# %% [markdown]
# ## The check
#
# The energies of all eight portfolios by Qiskit's Ising model, and the eight probabilities of the
# bell, against the two formulas in numpy.

# %%
names = [f"portfolio {k:03b}" for k in range(8)] + [f"price {price:.2f}" for price in prices]
verdict(CHECK, names)

# %% [markdown]
# ## Try it yourself
#
# 1. At which taste for risk $q$ does the best pair change?
# 2. `sigma` here is the variance, not the deviation. How does the check notice a mix-up?
