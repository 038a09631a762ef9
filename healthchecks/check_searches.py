# %% [markdown]
# # The compiled search: the shortest tour past picks
#
# A picker walks from the depot past all picks of a trip and back. In a rectangular warehouse the
# shortest tour is found aisle by aisle, from left to right: all that matters of what was decided
# so far is how often each cross aisle is used at this aisle (0, 1 or 2 times) and what is
# connected (Ratliff and Rosenthal 1983). qRobot does this by machine code that numba makes of
# Python, because a search for good batches asks for millions of tours.

# %%
import itertools

from qrobot.health.checks.searches import AISLES, CHECK, PICKS, SLOTS
from qrobot.health.lesson import table, verdict
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.routing import Router

table(["tour", "picks (aisle, slot)"], list(enumerate(PICKS)))

# %%
warehouse = AisleWarehouse(AISLES, SLOTS)
compiled, plain = Router(warehouse, compiled=True), Router(warehouse, compiled=False)
table(
    ["tour", "machine code", "the same in numpy"],
    [
        (k, compiled.length(slots), plain.length(slots))
        for k, slots in enumerate([Slot(*pick) for pick in picks] for picks in PICKS)
    ],
)

# %% [markdown]
# ## Every sequence
#
# Four picks have 24 sequences, and the best one is as long as the tour that was found. Ten picks
# have 3,628,800 sequences; going from aisle to aisle takes as many steps as there are aisles.

# %%
for picks in PICKS:
    slots = [Slot(*pick) for pick in picks]
    matrix = warehouse.distance_matrix(slots)
    print(
        min(
            sum(matrix[a][b] for a, b in itertools.pairwise((0, *tour, 0)))
            for tour in itertools.permutations(range(1, len(matrix)))
        )
    )

# %% [markdown]
# ## The check
#
# What the machine code found, against all sequences with distances by hand.

# %%
verdict(CHECK, ["4 picks", "3 picks"])

# %% [markdown]
# ## Try it yourself
#
# 1. Give the warehouse two blocks (`AisleWarehouse(AISLES, SLOTS, 2)`): do tours become shorter?
# 2. Time `compiled.length` and `plain.length` with `timeit`.
