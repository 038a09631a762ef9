"""Plans read back from files, what may stand for a plan, and `check`, which takes it."""

from __future__ import annotations

import os
from typing import Any

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.plan.checker import CheckReport
from qrobot.plan.checker import check as check_plan
from qrobot.plan.plan import Plan
from qrobot.problem import Instance
from qrobot.problem.formats import instance_of
from qrobot.problem.formats.jsontext import loads, located

__all__ = ["check", "plan_of", "read_plan"]


def check(plan: Plan | StrPath, instance: Instance | StrPath) -> CheckReport:
    """Verify a plan against the question, without any solver's code.

    Parameters
    ----------
    plan
        The answer: a plan, a result, or the path of a plan's file.
    instance
        The question, or the path of its file; when its orders were split
        (`Instance.split_orders`), items of one order may be on several trips.

    Returns
    -------
    CheckReport
        As of `qrobot.plan.checker.check`, which tells all that is looked at.

    Raises
    ------
    InputError
        When one of them is something else, or a file cannot be read.
    """
    return check_plan(plan_of(plan), instance_of(instance))


def read_plan(path: StrPath) -> Plan:
    """Read a plan that `Result.save` or ``qrobot solve --output`` wrote.

    Raises
    ------
    InputError
        When the file is not a plan, with line and column.
    """
    text = read_text(path)
    try:
        with located(text):
            return Plan.from_dict(loads(text))
    except InputError as error:
        raise error.in_file(os.fspath(path)) from None


def plan_of(answer: Any) -> Plan:
    """Return a plan: as it is, that of a result, or that of a file.

    Raises
    ------
    InputError
        When it is none of these, or the file is not a plan.
    """
    if isinstance(answer, str | os.PathLike):
        return read_plan(answer)
    plan = getattr(answer, "plan", answer)
    if isinstance(plan, Plan):
        return plan
    raise InputError(
        f"an object of class {type(answer).__name__} is not a plan",
        advice="give a result of qrobot.solve, its plan, or the path of a plan's file",
    )
