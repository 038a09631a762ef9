"""Scattered storage: places are chosen first, together with one tour past all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from qrobot.backends import Stop
from qrobot.backends.classical.scattered import can_choose, choose_places
from qrobot.plan.objective import Objective
from qrobot.planning.run import Progress, Run
from qrobot.planning.strategy import Strategy
from qrobot.problem import Instance
from qrobot.problem.instance import ELSEWHERE

__all__ = ["plan_after_places", "run_with_places"]

CHOOSERS = ("auto", "exact")
"""Backends that choose places; others take items from their own."""

CHOOSING_SHARE = 0.5
"""Of the time, for the choice."""


def run_with_places(
    instance: Instance,
    backend: str,
    stop: Stop,
    seed: int,
    on_progress: Callable[[Progress], None] | None,
    objective: Objective,
) -> Run | None:
    """Return a run on the places of a shortest tour, or None where none are chosen.

    The tour is its plan when one robot may make it; then nothing is left to do.
    """
    if backend not in CHOOSERS or not can_choose(instance):
        return None
    seconds = CHOOSING_SHARE * stop.remaining if stop.remaining < float("inf") else None
    placed = choose_places(instance, stop.within(seconds))
    if placed is None:
        return None
    uncertain = _handling_of_places(placed.instance, objective)
    run = Run(placed.instance, stop, seed, on_progress, objective=objective, seated=uncertain > 0.0)
    run.record.notes = [note for note in run.record.notes if note != ELSEWHERE]
    run.begin("places")
    run.best.raise_bound(placed.bound)
    run.best.bound -= uncertain
    run.best.offer([placed.route])
    return run


def _handling_of_places(instance: Instance, objective: Objective) -> float:
    """Return what handling costs that other places might not cost.

    They may take fewer picks, and be on lower levels.
    """
    certain = replace(instance.times, per_pick=0.0, per_level=0.0)
    return objective.fixed(instance) - objective.fixed(replace(instance, times=certain))


def plan_after_places(run: Run, strategy: Strategy) -> None:
    """Plan several trips past chosen places; the bound stays that of the tour."""
    run.record.notes.append(
        "the places were chosen for one tour past all of them, then the trips were planned: "
        "other places may give a shorter plan"
    )
    bound = run.best.bound
    strategy.plan(run)
    run.best.bound, run.best.proven = bound, False
