# %% [markdown]
# # PyVRP: routes by breeding
#
# PyVRP is a vehicle routing solver with a C++ core: it destroys and repairs plans, improves them
# by local moves, and allows too heavy trips at a price on the way. qRobot calls it when a
# proof is out of reach.

# %%
from pyvrp import Model
from pyvrp.stop import MaxIterations

from qrobot.health import known
from qrobot.health.checks.pyvrp import CHECK, ROBOTS, ROOM, SPOTS, WEIGHTS, between
from qrobot.health.lesson import draw, table, verdict

model = Model()
places = [model.add_location(*spot) for spot in SPOTS]
depot = model.add_depot(places[0])
for place, weight in zip(places[1:], WEIGHTS, strict=True):
    model.add_client(place, delivery=weight)
model.add_vehicle_type(ROBOTS, capacity=ROOM, start_depot=depot, end_depot=depot)
for a, start in enumerate(places):
    for b, end in enumerate(places):
        model.add_edge(start, end, distance=between(a, b))
best = model.solve(MaxIterations(200), seed=1, display=False).best
trips = [[stop.idx + 1 for stop in route if stop.is_client()] for route in best.routes()]
table(
    ["trip", "weight", "way"],
    [
        (str(trip), sum(WEIGHTS[s - 1] for s in trip), known.length([trip], between))
        for trip in trips
    ],
)


# %%
def picture(axes):
    """Draw each trip along aisles: first sideways, then up or down."""
    for trip in trips:
        way = [SPOTS[s] for s in (0, *trip, 0)]
        axes.step(*zip(*way, strict=True), where="post", marker="o")
    axes.plot(*SPOTS[0], "ks", markersize=9)
    axes.set_aspect("equal")


draw(picture, size=(3.4, 3.2))

# %% [markdown]
# Ways follow aisles: $|x_a - x_b| + |y_a - y_b|$, whole numbers, so "shortest" is exact.
#
# ## The check
#
# $6! \cdot 7 = 5040$ plans are measured in plain Python. PyVRP proves nothing, but a solver that
# misses the best of six stops in 200 rounds is broken. Its routes are measured anew, too.

# %%
verdict(CHECK, ["way told", "way measured", "stops served"])

# %% [markdown]
# ## Try it yourself
#
# 1. `MaxIterations(1)`: how far from the best is the first plan?
# 2. Lower `ROOM` to 10. The weights add up to 21: what does PyVRP give back, and what does
#    `best.is_feasible()` say?
