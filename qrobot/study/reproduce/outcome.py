"""One line of a reproduced table: what a method gave for a row by itself."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from qrobot._arrays import Floats
from qrobot.study.reproduce.question import Question, same

__all__ = ["Clock", "Outcome", "judged"]


class Clock:
    """Wall-clock seconds of the parts of a run."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("build", "search", "run", "decode"), 0.0)

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time of a block to a part."""
        begun = time.perf_counter()
        yield
        self.seconds[part] += time.perf_counter() - begun


@dataclass(slots=True)
class Outcome:
    """What one method gave for one row of the paper, raw: no repair, no polish.

    Parameters
    ----------
    table, items, robots, capacity, qubits
        The row: table, n, K, M, and the qubits of the model that was built.
    method, backend
        What ran.
    status, reason
        ``done``; ``skipped`` (not possible here, as the reason says); ``failed``.
    states
        Amplitudes that were simulated; ``None`` for annealers.
    reads
        Shots or reads, the control's too.
    seconds
        Building the model, searching parameters and sampling; imports, compilation and
        decoding left out.
    build_seconds, search_seconds, run_seconds, decode_seconds
        The parts; ``run`` is the sampling alone.
    optimum, proven
        The least distance and whether the exact planner proved it.
    best, gap
        Least distance among the reads, and best / optimum - 1; ``None`` without a feasible
        read.
    feasible, share
        Shares of the reads that are feasible, and that are an optimal plan.
    probability
        Of reading an optimal plan in one shot, where the state is known exactly.
    control
        What the random guesses are: ``bit strings`` or ``plans``.
    control_best, control_feasible, control_probability, control_seen
        The same of as many random guesses; ``seen``: the probability that an optimal plan
        is among them.
    plans_probability, plans_best
        The stricter control for every method: of a uniformly random feasible plan, and the
        expected best of as many.
    paper_annealer_seconds, paper_ibmq_seconds, paper_pennylane_seconds
        What the paper prints for this n in this table.
    details
        Parameters worth keeping, plain data.
    """

    table: int
    items: int
    robots: int
    capacity: int
    qubits: int
    method: str
    backend: str
    status: Literal["done", "skipped", "failed"] = "done"
    reason: str | None = None
    states: int | None = None
    reads: int | None = None
    seed: int | None = None
    seconds: float | None = None
    build_seconds: float | None = None
    search_seconds: float | None = None
    run_seconds: float | None = None
    decode_seconds: float | None = None
    optimum: float | None = None
    proven: bool = False
    best: float | None = None
    gap: float | None = None
    feasible: float | None = None
    share: float | None = None
    probability: float | None = None
    control: str | None = None
    control_best: float | None = None
    control_feasible: float | None = None
    control_probability: float | None = None
    control_seen: float | None = None
    plans_probability: float | None = None
    plans_best: float | None = None
    paper_annealer_seconds: float | None = None
    paper_ibmq_seconds: float | None = None
    paper_pennylane_seconds: float | None = None
    details: dict[str, Any] = field(default_factory=dict)


def judged(
    line: Outcome,
    question: Question,
    distances: Floats,
    clock: Clock,
    *,
    seed: int,
    plans_only: bool = False,
) -> Outcome:
    """Fill a line from the distances of its raw reads, and the control at equal shots.

    Parameters
    ----------
    line
        The line; gets everything but what only the method knows.
    question
        The row.
    distances
        Of every read, ``inf`` where it is no plan, shape (reads,).
    clock
        Where the time went.
    seed
        Of the control.
    plans_only
        Whether the method can read nothing but feasible plans; then so does the control.
    """
    reads = len(distances)
    line.qubits = question.model.num_variables
    random = question.random_plans if plans_only else question.bit_strings
    control = random(reads, seed)
    best = float(distances.min(initial=math.inf))
    parts = clock.seconds
    line.reads, line.seed = reads, seed
    line.seconds = parts["build"] + parts["search"] + parts["run"]
    for part, spent in parts.items():
        setattr(line, f"{part}_seconds", spent)
    line.optimum, line.proven = question.optimum, True
    line.best = best if math.isfinite(best) else None
    if math.isfinite(best):
        gap = best / question.optimum - 1
        line.gap = gap if abs(gap) > 1e-9 else 0.0  # both directions of a tour: other last digits
    line.feasible = float(np.isfinite(distances).mean())
    line.share = float(same(distances, question.optimum).mean())
    line.control = control.kind
    line.control_best, line.control_feasible = control.best, control.feasible
    line.control_probability = control.probability
    line.control_seen = -math.expm1(reads * math.log1p(-min(control.probability, 1 - 1e-16)))
    line.plans_probability = question.plans.optimal / question.plans.size
    line.plans_best = question.expected_best_plan(reads)
    return line
