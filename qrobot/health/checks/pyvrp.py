"""PyVRP: the shortest trips of two robots, held against all."""

from qrobot.health import known
from qrobot.health.check import Check

SPOTS = ((0, 0), (30, 41), (-22, 53), (61, -14), (-43, -35), (12, -60), (-70, 5))
"""The depot, then the stops."""

WEIGHTS, ROOM, ROBOTS = (4, 3, 5, 2, 4, 3), 11, 2


def between(a: int, b: int) -> int:
    """Return the way along aisles between two spots."""
    return abs(SPOTS[a][0] - SPOTS[b][0]) + abs(SPOTS[a][1] - SPOTS[b][1])


def answer() -> list[float]:
    """Return the distance that is told, that of the routes measured anew, and the stops."""
    import pyvrp
    from pyvrp.stop import MaxIterations

    model = pyvrp.Model()
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
    return [float(best.distance()), known.length(trips, between), float(sum(map(len, trips)))]


def expected() -> list[float]:
    """Return the least distance, twice, and all stops."""
    return [*[known.shortest(WEIGHTS, ROOM, between)] * 2, len(WEIGHTS)]


CHECK = Check(
    __name__,
    title="trips of two robots, 6 stops",
    group="solver",
    imports=("pyvrp", "pyvrp.stop"),
    distributions=("pyvrp",),
    source="all plans, in plain Python",
    extra="planners",
)
