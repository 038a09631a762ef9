"""The paper's reduced encoding: K n (n + 1) variables and the slack.

The full encoding with the depot's layers t = 0 and t = n + 1 put in as the constants that
the constraints make them. Tables 2 and 3 of the paper count these.
"""

from __future__ import annotations

import numpy as np

from qrobot.models.fleet import fleet_of
from qrobot.models.layout import VariableLayout, check_size, layered
from qrobot.models.slack import Slack, slack_coefficients
from qrobot.problem import Instance

__all__ = ["reduced_layout"]


def reduced_layout(instance: Instance, slack: Slack) -> VariableLayout:
    """Return the variables of the reduced encoding."""
    fleet = fleet_of(instance, every_robot=True)
    n, robots = instance.size, len(fleet)
    check_size(robots * n * (n + 1), "reduced")
    everywhere = np.ones((n, n + 1), dtype=np.bool_)
    return layered(
        "reduced",
        fleet,
        n,
        first=1,
        last=np.full(robots, n, dtype=np.int64),
        allowed=[everywhere] * robots,
        slack=[slack_coefficients(room, slack) for room in fleet.capacities.tolist()],
        summed=np.ones(robots, dtype=np.bool_),
        paired=np.zeros(robots, dtype=np.bool_),
    )
