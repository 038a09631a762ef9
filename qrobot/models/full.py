"""The paper's full encoding: K (n + 1) (n + 2) variables and the slack.

x[t, i, p] for every step t = 0 .. n + 1, every node i = 0 .. n and every robot p. Being at
the depot at both ends is a constraint like the others. Table 1 of the paper counts these.
"""

from __future__ import annotations

import numpy as np

from qrobot.models.fleet import fleet_of
from qrobot.models.layout import VariableLayout, check_size, layered
from qrobot.models.slack import Slack, slack_coefficients
from qrobot.problem import Instance

__all__ = ["full_layout"]


def full_layout(instance: Instance, slack: Slack) -> VariableLayout:
    """Return the variables of the full encoding."""
    fleet = fleet_of(instance, every_robot=True)
    n, robots = instance.size, len(fleet)
    check_size(robots * (n + 1) * (n + 2), "full")
    everywhere = np.ones((n + 2, n + 1), dtype=np.bool_)
    return layered(
        "full",
        fleet,
        n,
        first=0,
        last=np.full(robots, n + 1, dtype=np.int64),
        allowed=[everywhere] * robots,
        slack=[slack_coefficients(room, slack) for room in fleet.capacities.tolist()],
        summed=np.ones(robots, dtype=np.bool_),
        paired=np.zeros(robots, dtype=np.bool_),
    )
