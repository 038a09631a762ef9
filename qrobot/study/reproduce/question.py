"""What a row asks, its proven optimum, what random guessing would give, and what a method gave."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.backends.gate import Spectrum, expected_best, feasible_set, spectrum
from qrobot.errors import BackendError
from qrobot.models import PickingModel, build_model
from qrobot.planning import solve
from qrobot.problem import Instance
from qrobot.study.reproduce.paper import ENUMERATED, PaperRow, table_instance

__all__ = ["Clock", "Control", "Outcome", "Question", "judged", "same"]


STREAM = 0xC0
"""Sets the control's random numbers apart from a method's with the same seed."""


def same(distances: Floats, optimum: float) -> npt.NDArray[np.bool_]:
    """Return which distances are the optimum, to 1e-9 of it."""
    return np.asarray(distances <= optimum * (1 + 1e-9))


@dataclass(frozen=True, slots=True)
class Control:
    """What random guesses of one kind give.

    Parameters
    ----------
    kind
        ``bit strings`` (uniform over all qubits) or ``plans`` (uniform feasible plans).
    feasible, probability
        Of one guess being feasible, and optimal: exact, by counting all plans.
    best
        Least distance of as many guesses as reads, drawn with the seed; ``None`` when none
        was feasible.
    """

    kind: str
    feasible: float
    probability: float
    best: float | None


@dataclass(frozen=True, eq=False)
class Question:
    """A row's instance with all that is known about it.

    Parameters
    ----------
    row
        Of the paper.
    instance
        Ours in its shape.
    model
        In the row's encoding with the paper's slack and the measured penalties.
    optimum
        Least distance, proven by the exact planner.
    plans
        How many plans have which distance: enumerated up to 9 items, then counted.
    """

    row: PaperRow
    instance: Instance
    model: PickingModel
    optimum: float
    plans: Spectrum

    @classmethod
    def of(cls, row: PaperRow, seed: int) -> Question:
        """Pose a row's question.

        Raises
        ------
        BackendError
            When the exact planner and the count of all plans do not agree, or the model has
            another number of qubits than the paper's: then every figure would be worthless.
        """
        instance = table_instance(row, seed)
        model = build_model(instance, row.encoding, slack="paper")
        proven = solve(instance, backend="exact", deadline=600)
        if proven.ended == "interrupted":  # `solve` keeps Ctrl-C to itself
            raise KeyboardInterrupt
        plans = spectrum(instance) if row.items > ENUMERATED else _enumerated(instance)
        if not (proven.is_optimal and abs(proven.cost - plans.levels[0]) < 1e-6):
            raise BackendError(
                f"the exact planner says {proven.cost:.12g} for {row.items} items, counting all "
                f"plans says {plans.levels[0]:.12g}"
            )
        if model.num_variables != row.qubits:
            raise BackendError(
                f"the model of {row.items} items has {model.num_variables} qubits, the paper's "
                f"{row.qubits}"
            )
        return cls(row, instance, model, proven.cost, plans)

    def bit_strings(self, reads: int, seed: int) -> Control:
        """Return what uniform bit strings give, whatever their slack bits say.

        With one robot every plan is one setting of the x variables, so the shares follow
        from the number of plans.
        """
        settings = 2.0**self.model.layout.places
        rng = np.random.default_rng([seed, STREAM])
        bits = rng.integers(2, size=(reads, self.model.num_variables), dtype=np.int8)
        drawn = dimod.SampleSet.from_samples_bqm((bits, self.model.variables), self.model.bqm)
        best = float(self.model.decode_all(drawn).distances.min())
        return Control(
            "bit strings",
            feasible=self.plans.size / settings,
            probability=self.plans.optimal / settings,
            best=best if np.isfinite(best) else None,
        )

    def random_plans(self, reads: int, seed: int) -> Control:
        """Return what uniform feasible plans give."""
        shares = self.plans.counts / self.plans.size
        drawn = np.random.default_rng([seed, STREAM]).choice(self.plans.levels, reads, p=shares)
        return Control("plans", 1.0, self.plans.optimal / self.plans.size, float(drawn.min()))

    def expected_best_plan(self, reads: int) -> float:
        """Return the expected best distance of as many uniform feasible plans."""
        return expected_best(self.plans.levels, self.plans.counts / self.plans.size, reads)


def _enumerated(instance: Instance) -> Spectrum:
    """Return how many plans have which distance, by listing them."""
    costs = np.sort(feasible_set(instance).costs)
    # Both directions of a tour differ in the last digits.
    first = np.concatenate([[True], np.diff(costs) > 1e-9 * costs[-1]])
    starts = np.flatnonzero(first)
    return Spectrum(costs[starts], np.diff([*starts.tolist(), len(costs)]))


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
        Of every read, ``inf`` where it is not a plan, shape (reads,).
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
