# %% [markdown]
# # Jupyter: the thing that you are looking at
#
# A notebook has two halves. The front shows cells; the *kernel* is a Python process that runs them.
# They talk over sockets: "execute this", "here is what it printed", "I am idle". `nbclient` is a
# front without a screen: `qrobot health --notebooks` ran this very notebook with it.

# %%
import os

import nbformat
from IPython import get_ipython

from qrobot.health.checks.jupyter import CELLS, CHECK
from qrobot.health.lesson import table, verdict

print("this kernel is process", os.getpid(), "of", os.getppid())
shell = get_ipython()
print("it is a", type(shell).__name__ if shell else "plain script, without a kernel")

# %% [markdown]
# ## A notebook is a text file
#
# An `.ipynb` is JSON: cells, their sources and their outputs. That is why it does badly in version
# control, and why the sources here are plain Python with `# %%` between cells (see
# `check_jupytext`).

# %%
notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
print(nbformat.writes(notebook)[:320], "...")

# %% [markdown]
# ## The check: a notebook inside a notebook
#
# The three cells below are executed in a second kernel, a child of this one. What one cell prints
# and what another one's value is are the numerator and the denominator of
# $1 + \frac12 + \dots + \frac1{10} = \frac{7381}{2520}$ (OEIS A001008 and A002805). That the later
# cells know `total` shows that they share one process.

# %%
table(["cell", "source"], [(k, text) for k, text in enumerate(CELLS, 1)])
verdict(CHECK, ["printed", "value"])

# %% [markdown]
# ## Try it yourself
#
# 1. What happens to the second cell when the first one calls `os._exit(1)`? Who notices?
# 2. JupyterLab on a robot must never be open to the network without a token. Where is it set in
#    `docker/`?
