"""The answer: trips and plans, and the checker that trusts no solver."""

from qrobot.plan.checker import CheckReport, Problem
from qrobot.plan.clock import Measures
from qrobot.plan.files import check, plan_of, read_plan
from qrobot.plan.objective import OBJECTIVES, Objective, objective_named
from qrobot.plan.picks import Pick, as_picked
from qrobot.plan.plan import PLAN_SCHEMA, Plan, Trip

__all__ = [
    "OBJECTIVES",
    "PLAN_SCHEMA",
    "CheckReport",
    "Measures",
    "Objective",
    "Pick",
    "Plan",
    "Problem",
    "Trip",
    "as_picked",
    "check",
    "objective_named",
    "plan_of",
    "read_plan",
]
