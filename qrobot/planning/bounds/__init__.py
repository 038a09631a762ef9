"""Lower bounds that hold for any plan, for instances too large to prove exactly."""

from qrobot.planning.bounds.lagrange import forest_bound, load_steps, walk_bound
from qrobot.planning.bounds.quick import (
    fewest_trips,
    least_trips,
    most_trips,
    quick_bound,
    radial_bound,
    tours_bound,
)
from qrobot.planning.bounds.schedule import schedule_bound

__all__ = [
    "fewest_trips",
    "forest_bound",
    "least_trips",
    "load_steps",
    "most_trips",
    "quick_bound",
    "radial_bound",
    "schedule_bound",
    "tours_bound",
    "walk_bound",
]
