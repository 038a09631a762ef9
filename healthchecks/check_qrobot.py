# %% [markdown]
# # qRobot: five orders, two robots, the best plan
#
# The solver of this project itself. Robots start at the depot, collect what fits and come back;
# wanted is the shortest total way. For a few orders the exact planner proves its answer, and an
# independent checker, which shares no code with it, measures the plan anew.

# %%
import math
from fractions import Fraction

import qrobot
from qrobot.health.checks.qrobot import CHECK, ROBOTS, ROOM, SPOTS, WEIGHTS
from qrobot.health.lesson import draw, table, verdict
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

names = [f"i{k}" for k in range(len(SPOTS))]
instance = Instance(
    warehouse=OpenFloor(depot_x=0.0, depot_y=0.0),
    items=tuple(
        Item(name, Fraction(weight), Point(*spot))
        for name, weight, spot in zip(names, WEIGHTS, SPOTS, strict=True)
    ),
    orders=tuple(Order(name, (name,)) for name in names),
    robots=tuple(Robot(f"R{k}", Fraction(ROOM)) for k in range(ROBOTS)),
)
result = qrobot.solve(instance, backend="exact", deadline=60)
print(result.summary())

# %%
trips = [trip["stops"] for trip in result.plan.to_dict()["trips"]]


def picture(axes):
    """Draw the trips, the depot as a square."""
    for trip in trips:
        way = [(0, 0), *(SPOTS[names.index(stop)] for stop in trip), (0, 0)]
        axes.plot(*zip(*way, strict=True), marker="o")
    axes.plot(0, 0, "ks", markersize=9)
    axes.set_aspect("equal")


draw(picture, size=(3.2, 3.2))

# %% [markdown]
# ## How many plans are there?
#
# Put the five stops into a sequence ($5! = 120$) and cut it into two trips (6 places): 720 plans,
# each counted several times. Greedy is quick and pays for it:

# %%


def greedy():
    """Always the nearest stop that still fits; home when none does."""
    left, length = set(range(len(SPOTS))), 0.0
    while left:
        here, room = (0.0, 0.0), ROOM
        while fits := [k for k in left if WEIGHTS[k] <= room]:
            nearest = min(fits, key=lambda k: math.dist(here, SPOTS[k]))
            length, here = length + math.dist(here, SPOTS[nearest]), SPOTS[nearest]
            room -= WEIGHTS[nearest]
            left.remove(nearest)
        length += math.dist(here, (0.0, 0.0))
    return length


table(["method", "way"], [("greedy", greedy()), ("exact", float(result.plan.distance))])

# %% [markdown]
# ## The check
#
# All 720 are measured in plain Python. The plan must be as short as the best, be called proven, and
# the checker must have no complaint.

# %%
verdict(CHECK, ["way", "proven", "complaints"])

# %% [markdown]
# ## Try it yourself
#
# 1. Give the robots room for 20. Does one trip become best, and must it?
# 2. `backend="neal"` asks an annealer. How many of its raw reads are plans at all?
