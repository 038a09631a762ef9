"""qRobot's exact solver: the best plan of a small floor, held against all plans."""

import math

from qrobot.health import known
from qrobot.health.check import Check

SPOTS = ((3.0, 4.0), (-2.0, 5.0), (6.0, -1.0), (-4.0, -3.0), (1.0, -6.0))
WEIGHTS, ROOM, ROBOTS = (4, 3, 5, 2, 4), 10, 2


def answer() -> list[float]:
    """Return the distance of the plan, whether it is proven, and its checker's complaints."""
    from fractions import Fraction

    import qrobot
    from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

    ids = [f"i{k}" for k in range(len(SPOTS))]
    instance = Instance(
        warehouse=OpenFloor(depot_x=0.0, depot_y=0.0),
        items=tuple(
            Item(name, Fraction(weight), Point(*spot))
            for name, weight, spot in zip(ids, WEIGHTS, SPOTS, strict=True)
        ),
        orders=tuple(Order(name, (name,)) for name in ids),
        robots=tuple(Robot(f"R{k}", Fraction(ROOM)) for k in range(ROBOTS)),
    )
    result = qrobot.solve(instance, backend="exact", deadline=60)
    plan = result.plan
    complaints = len(qrobot.check(plan, instance).problems)
    return [float(plan.distance), float(result.is_optimal), float(complaints)]


def expected() -> list[float]:
    """Return the least distance over all plans."""
    spots = ((0.0, 0.0), *SPOTS)
    return [known.shortest(WEIGHTS, ROOM, lambda a, b: math.dist(spots[a], spots[b])), 1.0, 0.0]


CHECK = Check(
    __name__,
    title="the exact solver, 5 items, 2 robots",
    group="solver",
    imports=("qrobot.planning", "qrobot.problem"),
    distributions=("qrobot",),
    source="all plans, in plain Python",
    quick=True,
)
