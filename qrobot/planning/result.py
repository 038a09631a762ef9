"""What `solve` returns: the plan, how good it is, and where the time went."""

from __future__ import annotations

import math
import os
import tempfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from qrobot._files import write_text_atomic
from qrobot._json import json_text
from qrobot._notebook import html_table, shown_name
from qrobot._numbers import number
from qrobot.plan import Measures, Plan, objective_named
from qrobot.plan.plan import TABLE_HEADS
from qrobot.planning.own_trips import EachRobot
from qrobot.problem import Instance

__all__ = ["Ending", "Result", "SamplerReport", "Timing"]

Ending = Literal["proven", "deadline", "work", "interrupted", "finished"]

MOST_DRAWN = 500
"""Items of the largest plan whose picture a notebook shows by itself."""

_ENDINGS = {
    "proven": "stopped at the proof",
    "deadline": "stopped at the deadline",
    "work": "stopped at the limit of work",
    "interrupted": "interrupted: the best plan so far",
    "finished": "the backend finished its work",
}


@dataclass(slots=True, repr=False)
class SamplerReport:
    """What a sampler found by itself, before any repair or polish.

    Parameters
    ----------
    backend, encoding
        Which sampler ran on which model.
    variables
        Binary variables of the model (qubits).
    reads, rounds
        Samples taken, in how many rounds: while none is a plan, a local sampler is asked
        again with the broken constraint's weight raised.
    feasible_fraction
        Share of the reads that decode to a plan without any violation.
    best, mean
        Least and mean distance of the feasible reads; ``None`` without one.
    energy
        Least energy of all reads, feasible or not.
    control_best, control_mean
        Least and mean distance that the same number of random starts gave after the same
        repair and polish; ``None`` when no control was asked for.
    polished_best
        Least distance that the sampler's reads gave after repair and polish.
    optimal_fraction
        Share of the reads that are optimal plans; ``None`` when the optimum is not proven.
    random_feasible_fraction, random_best, random_optimal_fraction
        The same as without ``random``, of as many uniformly random assignments; ``None``
        when no control was asked for.
    of_plans
        Whether the reads, and the random ones, are plans by construction: then no bit string
        is drawn, and `variables` are the qubits that a circuit would have.
    details
        What the sampler tells of itself: device, parameters, embedding, remote job.
    """

    backend: str
    encoding: str
    variables: int
    reads: int
    feasible_fraction: float
    best: float | None
    mean: float | None
    energy: float
    control_best: float | None = None
    control_mean: float | None = None
    polished_best: float | None = None
    optimal_fraction: float | None = None
    random_feasible_fraction: float | None = None
    random_best: float | None = None
    random_optimal_fraction: float | None = None
    rounds: int = 1
    of_plans: bool = False
    details: dict[str, Any] = field(default_factory=dict, compare=False)

    def __repr__(self) -> str:
        best = "no plan among them" if self.best is None else f"best {number(self.best)}"
        return (
            f"<SamplerReport of {self.backend}: {_reads(self)} of {self.variables} variables, "
            f"{_percent(self.feasible_fraction)} feasible, {best}>"
        )


@dataclass(slots=True)
class Timing:
    """Wall-clock seconds of each part; parts that did not happen are zero.

    Parameters
    ----------
    build
        Making the model from the instance.
    submit, latency, queue, return_
        Remote backends only: handing over, network, waiting, fetching.
    run
        The sampler's or planner's own work.
    decode, polish
        Reading samples; repair and local search.
    bound
        Proving a lower bound.
    check
        The independent checker.
    total
        From the call of `solve` to its return, everything included.
    """

    build: float = 0.0
    submit: float = 0.0
    latency: float = 0.0
    queue: float = 0.0
    run: float = 0.0
    return_: float = 0.0
    decode: float = 0.0
    polish: float = 0.0
    bound: float = 0.0
    check: float = 0.0
    total: float = 0.0

    def to_dict(self) -> dict[str, float]:
        """Return the seconds by name (``return_`` as ``return``)."""
        return {name.rstrip("_"): value for name, value in asdict(self).items()}


@dataclass(frozen=True, repr=False)
class Result:
    """A checked plan and everything that is known about it.

    Parameters
    ----------
    instance, plan
        The question and the answer; the checker has accepted the plan.
    bound
        A valid lower bound of the cost of any plan.
    is_optimal
        True only when a proof says that no plan costs less.
    backend
        The backend that was asked for.
    steps
        What was run, in sequence, such as ``["pyvrp", "exact"]``.
    seed
        Of every random choice.
    work
        Work units done by each step.
    ended
        Why the search ended.
    sampler
        What the sampler gave by itself, for sampler backends.
    timing
        Where the time went.
    notes
        Facts that the reader must know: about the input, a fallback, a limit.
    answered_by
        The backend that answered: `backend`, or the fallback that stepped in.
    measures
        What the plan comes to by every measure, as the checker found: metres, seconds of work,
        when the last robot is back, lateness, trips, robots.
    each_robot
        What the central plan cost, where each robot planned its own sequences (`route_each`).
    """

    instance: Instance
    plan: Plan
    bound: float
    is_optimal: bool
    backend: str
    steps: tuple[str, ...] = ()
    seed: int = 0
    work: dict[str, int] = field(default_factory=dict)
    ended: Ending = "finished"
    sampler: SamplerReport | None = None
    timing: Timing = field(default_factory=Timing)
    notes: tuple[str, ...] = ()
    answered_by: str = ""
    measures: Measures | None = None
    each_robot: EachRobot | None = None

    def __post_init__(self) -> None:
        """Say who answered: who was asked, unless a fallback did."""
        if not self.answered_by:
            object.__setattr__(self, "answered_by", self.backend)

    def __repr__(self) -> str:
        return f"<Result of {self._headline()}>"

    def _headline(self) -> str:
        return (
            f"{shown_name(self.instance.name)} by {self.answered_by}: "
            f"{self._cost()}, {self._quality()}, {len(self.plan.trips)} trips"
        )

    def _repr_html_(self) -> str:
        """Return a table for notebooks, and the picture where matplotlib is installed."""
        title = f"Result of {self._headline()}"
        return html_table(title, TABLE_HEADS, self.plan.rows(), self._picture())

    def _picture(self) -> str:
        """Return the picture as inline SVG, or nothing when it cannot be drawn."""
        import qrobot

        if self.instance.size > MOST_DRAWN:
            return ""
        try:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "plan.svg"
                qrobot.plot(self, path)
                text = path.read_text(encoding="utf-8")
        except Exception:  # whatever hinders a picture: the table must be shown
            return ""
        return text[text.index("<svg") :]

    def _quality(self) -> str:
        if self.is_optimal:
            return "proven optimal"
        if math.isinf(self.gap):
            return "no lower bound is known"
        # Rounded up: the statement must stay true.
        above = math.ceil(self.gap * 1e4) / 1e4
        return f"at most {above:.2%} above the optimum (bound {number(self.bound)})"

    @property
    def cost(self) -> float:
        """What the plan costs by its objective: total distance, metres, or seconds."""
        return self.plan.cost

    @property
    def objective(self) -> str:
        """Name of what was made small, such as ``distance``."""
        return self.plan.objective

    def _cost(self) -> str:
        """Return the cost with its name, and the distance beside another objective."""
        if self.objective == "distance":
            return f"distance {number(self.cost)}"
        unit = f" {objective_named(self.objective).unit}".rstrip()
        return f"{self.objective} {number(self.cost)}{unit} (distance {number(self.plan.distance)})"

    @property
    def late(self) -> dict[str, float]:
        """For each order that is back after its due time by how much, seconds."""
        return {} if self.measures is None else self.measures.late(self.instance)

    @property
    def gap(self) -> float:
        """Largest possible share by which the plan exceeds the optimum: cost / bound - 1."""
        if self.is_optimal or self.cost <= self.bound:
            return 0.0
        return self.cost / self.bound - 1 if self.bound > 0 else math.inf

    def summary(self) -> str:
        """Return the result in a few plain lines."""
        robots = len(self.instance.robots)
        lines = [
            f"{self.instance.name}: {self.instance.size} items in {len(self.instance.orders)} "
            f"orders, {self.plan.robots_used} of {robots} robots used",
            f"{self._cost()}, {self._quality()}",
            f"{' + '.join(self.steps) or self.backend} in {self.timing.total:.2f} s, "
            f"{_ENDINGS[self.ended]}",
        ]
        if due := sum(math.isfinite(order.due) for order in self.instance.orders):
            late = self.late
            longest = f", at most by {number(max(late.values()))} s" if late else ""
            lines.insert(2, f"{len(late)} of {due} orders with a due time are late{longest}")
        if (s := self.sampler) is not None:
            best = (
                "no feasible read"
                if s.best is None or s.mean is None
                else f"best {number(s.best)}, mean {number(s.mean)}"
            )
            lines.append(
                f"{s.backend} by itself ({s.encoding}, {s.variables} variables, {_reads(s)}): "
                f"{_percent(s.feasible_fraction)} feasible, {best}{_optimal(s.optimal_fraction)}"
            )
            if s.random_feasible_fraction is not None:
                best = "none" if s.random_best is None else f"best {number(s.random_best)}"
                lines.append(
                    f"control, as many random {'plans' if s.of_plans else 'reads'}: "
                    f"{_percent(s.random_feasible_fraction)} feasible, "
                    f"{best}{_optimal(s.random_optimal_fraction)}"
                )
            if s.control_best is not None and s.control_mean is not None:
                lines.append(
                    f"control, as many random starts with the same repair and polish: "
                    f"best {number(s.control_best)}, mean {number(s.control_mean)}"
                )
        if self.each_robot is not None:
            lines.append(self.each_robot.to_text())
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return the plan with all that is known about it as plain data.

        The outer object is a plan of schema ``qrobot.plan/1``; its field ``result`` holds
        the rest.
        """
        data = self.plan.to_dict()
        data["result"] = {
            "objective": self.objective,
            "cost": self.cost,
            "bound": self.bound,
            "gap": self.gap if math.isfinite(self.gap) else None,
            "is_optimal": self.is_optimal,
            "robots_used": self.plan.robots_used,
            "measures": None if self.measures is None else self.measures.to_dict(),
            "late": self.late,
            "each_robot": None if self.each_robot is None else self.each_robot.to_dict(),
            "backend": self.backend,
            "answered_by": self.answered_by,
            "steps": list(self.steps),
            "seed": self.seed,
            "work": self.work,
            "ended": self.ended,
            "sampler": asdict(self.sampler) if self.sampler else None,
            "timing": self.timing.to_dict(),
            "notes": list(self.notes),
        }
        return data

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result as JSON; never leaves a half-written file.

        Raises
        ------
        InputError
            When the file cannot be written.
        """
        write_text_atomic(path, json_text(self.to_dict(), indent=1, ensure_ascii=False) + "\n")


def _optimal(share: float | None) -> str:
    return "" if share is None else f", {_percent(share)} optimal"


def _percent(share: float) -> str:
    return f"{share:.0%}" if share == 0 or share >= 0.1 else f"{100 * share:.2g}%"


def _reads(report: SamplerReport) -> str:
    rounds = f" in {report.rounds} rounds" if report.rounds > 1 else ""
    return f"{report.reads} reads{rounds}"
