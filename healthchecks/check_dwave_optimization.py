# %% [markdown]
# # dwave-optimization: decisions that are not bits
#
# A round trip in bits needs $n^2$ of them and penalties against everything that is not a trip.
# D-Wave's newer interface lets a decision be a list, a set or an integer. A list of stops *is* a
# sequence: nothing has to be forbidden. The model is a graph of array operations; the solver behind
# it runs in D-Wave's cloud, the model and its states are computed here.

# %%
import itertools

import numpy as np
from dwave.optimization import Model

from qrobot.health.checks.dwave_optimization import CHECK, LIMIT, STOPS, WAYS
from qrobot.health.lesson import draw, table, verdict

model = Model()
ways = model.constant(np.array(WAYS, dtype=float))
trip = model.list(STOPS)
length = ways[trip[:-1], trip[1:]].sum() + ways[trip[-1], trip[0]]
model.minimize(length)
print(model.num_nodes(), "nodes in the graph,", model.num_decisions(), "decision")

# %% [markdown]
# ## All states of a small model
#
# A state of the model is one choice for its decisions. With five stops there are $5! = 120$, each
# round trip ten times among them (five starts, two directions).

# %%
orders = list(itertools.permutations(range(STOPS)))
with model.lock():
    model.states.resize(len(orders))
    lengths = []
    for k, order in enumerate(orders):
        trip.set_state(k, order)
        lengths.append(float(model.objective.state(k)))
draw(lambda axes: axes.hist(lengths, bins=np.arange(min(lengths), max(lengths) + 2)))
best = sorted(zip(lengths, orders, strict=True))[:3]
table(["length", "sequence"], [(way, str(order)) for way, order in best])

# %% [markdown]
# Bits for the same question: $5^2 = 25$, of whose $2^{25}$ states 120 are trips.
#
# ## The check
#
# Each of the 120 lengths, and whether it keeps a limit, by the model and by adding up ways.

# %%
heads = [f"{''.join(map(str, o))}: {w}" for o in orders for w in ("length", f"<= {LIMIT}")]
verdict(CHECK, heads)

# %% [markdown]
# ## Try it yourself
#
# 1. Fix the start: model the trip over four stops with the depot outside. How many states are left?
# 2. Use `disjoint_lists` for two robots. Which constraint does the load of a robot become?
