# %% [markdown]
# # numba: machine code made on the spot
#
# numba turns a Python function into machine code for the processor that it runs on, by LLVM.
# Braket's simulator is built on it. On a robot it is a stack of special interest: a wheel was
# compiled elsewhere and can be wrong about the processor; numba compiles here.

# %%
import time

import numba

from qrobot.health.checks.numba import CHECK, COUNT
from qrobot.health.lesson import table, verdict


def squares(count):
    """Add up squares, one by one."""
    total = 0.0
    for k in range(count):
        total += k * k
    return total


compiled = numba.njit(squares)

# %% [markdown]
# ## Three calls
#
# The first call of the compiled function compiles it; the second only runs. Whatever is built on
# numba pays this once in every process, unless the machine code is kept in a cache.

# %%
rows = []
for name, function in (("Python", squares), ("first call", compiled), ("second call", compiled)):
    begun = time.perf_counter()
    total = function(300_000)
    rows.append((name, time.perf_counter() - begun, f"{total:.0f}"))
table(["", "seconds", "sum"], rows)

# %% [markdown]
# What it became: the types that numba found, and the size of the assembly for this processor.

# %%
for signature, code in compiled.inspect_asm().items():
    print(signature, "->", len(code.splitlines()), "lines of assembly for", end=" ")
print(numba.core.codegen.ll.get_host_cpu_name())

# %% [markdown]
# ## The check
#
# Two loops with closed forms: $\sum_{k<n} k^2 = \frac{(n-1)n(2n-1)}{6}$, and
# $\sum_{k<n} (\sqrt k)^2 = \frac{(n-1)n}{2}$, which adds rounding by a root.

# %%
verdict(CHECK, [f"squares below {COUNT}", "squares of roots"])

# %% [markdown]
# ## Try it yourself
#
# 1. Call `compiled(10.0)`. How many signatures are there now, and why?
# 2. `numba.njit(fastmath=True)` may reorder sums. Does the second number change?
