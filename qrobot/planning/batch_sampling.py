"""Whole orders in aisles by a sampler: who is asked for batches, and how the answer is reported."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import dimod
import numpy as np

from qrobot._numbers import number
from qrobot.backends import Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError, InputError, QRobotError
from qrobot.models.batches import Assignment, BatchModel
from qrobot.models.encodings import compact_layout
from qrobot.models.layout import MAX_VARIABLES
from qrobot.planning.bounding import time_to_search
from qrobot.planning.reads import call_parameters, split_options
from qrobot.planning.result import SamplerReport
from qrobot.planning.run import Run
from qrobot.problem import Instance

if TYPE_CHECKING:
    from qrobot.planning.proposals import BatchLoop

__all__ = ["ENCODING", "batch_parameters", "plan_batches", "wants_batches"]

ENCODING = "batches"
"""Its name among the encodings."""

MANY = 1_000
"""Binary variables of a model of sequences above which whole orders are sampled as batches: a
sampler seldom reads a plan from more."""

SWEEPS, FEWEST = 2, 100
"""Sweeps of an annealer for each variable of a model, and at least: small models need few."""

CONTROL_SHARE = 0.5
"""Of the time, for the control."""


def wants_batches(
    instance: Instance, sampler: PickingSampler, options: Mapping[str, Any], stop: Stop
) -> bool:
    """Return whether a sampler is asked for batches, and not for sequences of stops.

    It is where the caller says so, and where whole orders in aisles need a model of sequences
    with more variables than the sampler takes, or than `MANY` and the kernels are compiled, or
    may be, until `stop`.

    Raises
    ------
    InputError
        When the caller says so and it cannot be.
    """
    remote = sampler.runs_remotely(**options)
    most = min(sampler.capabilities.max_size or MAX_VARIABLES, MAX_VARIABLES)
    able = takes(instance) and not remote
    if options.get("encoding") == ENCODING:
        if not able:
            raise InputError(
                "batches are sampled in a warehouse of aisles, by a sampler on this machine, where "
                "numba is installed",
                field="encoding",
                advice="use the compact encoding",
            )
        for name in ("slack", "penalties"):
            if name in options:
                raise InputError(
                    f"the encoding batches has {name} of its own",
                    field=name,
                    advice="leave it out",
                )
        return True
    if {"encoding", "slack", "penalties"} & set(options) or not able:
        return False
    if instance.size == len(instance.orders) or len(instance.orders) > most:
        return False
    try:
        size = compact_layout(instance, "exact").size
    except InputError:
        return True
    return size > most or (size > MANY and compiled_soon(stop))


def batch_parameters(
    sampler: PickingSampler,
    model: BatchModel,
    scale: float,
    sampling: Mapping[str, Any],
    stop: Stop,
    seed: int,
) -> dict[str, Any]:
    """Return what a sampler is called with for a model of batches of this scale of energies."""
    parameters = call_parameters(sampler, scale, sampling, stop, seed)
    if "num_sweeps" in parameters and "num_sweeps" not in sampling:
        wanted = SWEEPS * model.bqm.num_variables
        parameters["num_sweeps"] = min(max(wanted, FEWEST), parameters["num_sweeps"])
    return parameters


def plan_batches(
    run: Run, sampler: PickingSampler, options: Mapping[str, Any], *, control: bool
) -> None:
    """Let a sampler propose batches until the deadline; report it apart from repair.

    Parameters
    ----------
    run
        The run; gets the best plan and the sampler's report.
    sampler, options
        Who is asked, with the options that the caller gave.
    control
        Whether random proposals, as many, go through the same loop.

    Raises
    ------
    InputError
        When an option is unknown or the model too large.
    BackendError
        When the sampler fails.
    """
    from qrobot.planning.proposals import BatchLoop, RandomSource, SamplerSource  # loads numba

    chosen = {name: value for name, value in options.items() if name != "encoding"}
    _, sampling = split_options(sampler, chosen)
    asked = _Asked(run, sampler, sampling)
    run.begin(sampler.name)
    stop = time_to_search(run)
    first = stop
    if control and math.isfinite(stop.remaining):
        first = stop.within((1.0 - CONTROL_SHARE) * stop.remaining)
    most = min(sampler.capabilities.max_size or MAX_VARIABLES, MAX_VARIABLES)
    limits = {"reads": sampling.get("num_reads"), "rounds": options.get("rounds")}
    loop = BatchLoop(run.instance, run.seed, SamplerSource(asked), run.best.offer, most)
    loop.run(first, **limits)
    if run.best.routes is None:
        run.best.offer(run.instance.first_routes() or [])
    run.out_of_time |= stop.remaining <= 0 or first.remaining <= 0
    run.record.work[sampler.name] = loop.work
    # The batches of a selection come from repaired plans: its reads are told apart.
    own = loop.assignment
    lengths = np.array(own.lengths)
    report = SamplerReport(
        backend=sampler.name,
        encoding=ENCODING,
        variables=own.variables,
        reads=own.proposals,
        feasible_fraction=len(lengths) / max(1, own.proposals),
        best=float(lengths.min()) if lengths.size else None,
        mean=float(lengths.mean()) if lengths.size else None,
        energy=asked.energy,
        polished_best=min(_repaired(loop), default=None),
        rounds=loop.rounds,
        details={"batches": dict(loop.facts())},
    )
    run.record.reads = (lengths, None)
    run.record.sampler = report
    run.record.notes += _notes(sampler.name, loop)
    if control:
        # Its plans are kept nowhere: it must not improve the plan that it is the control of.
        random = BatchLoop(run.instance, run.seed, RandomSource(), None, most)
        random.run(stop, **limits, most=loop.work)
        _tell_control(run, report, random)
    run.tell()


def _repaired(loop: BatchLoop) -> list[float]:
    return loop.assignment.repaired + loop.neighbourhood.repaired + loop.selection.repaired


def _notes(name: str, loop: BatchLoop) -> list[str]:
    """Say what is not the sampler's own: what began from repaired plans, and repair."""
    part, chosen, repaired = loop.neighbourhood, loop.selection, _repaired(loop)
    notes = []
    if part.proposals:
        notes.append(
            f"{name} dealt out anew the orders of a few trips of good plans ({part.variables} "
            f"variables, {part.proposals} reads): {len(part.lengths)} are plans as they are, "
            f"the best known so far in {number(part.better)} rounds of reads, after repair in "
            f"{number(part.repaired_better)}"
        )
    if chosen.proposals:
        best = f", best {number(min(chosen.lengths))}" if chosen.lengths else ""
        notes.append(
            f"{name} chose among batches of repaired plans ({chosen.variables} variables, "
            f"{chosen.proposals} reads): {len(chosen.lengths)} are plans as they are{best}"
        )
    if repaired:
        notes.append(
            f"repair made plans of {len(repaired)} of {loop.work} proposals of {name}: "
            f"best {number(min(repaired))}, mean {number(float(np.mean(repaired)))}"
        )
    return notes


def _tell_control(run: Run, report: SamplerReport, random: BatchLoop) -> None:
    own = random.assignment
    lengths, repaired = np.array(own.lengths), _repaired(random)
    report.random_feasible_fraction = len(lengths) / max(1, own.proposals)
    report.random_best = float(lengths.min()) if lengths.size else None
    if repaired:
        report.control_best, report.control_mean = min(repaired), float(np.mean(repaired))
    report.details["control"] = dict(random.facts())
    run.record.reads = (run.record.reads[0] if run.record.reads else lengths, lengths)
    wanted = run.record.work[report.backend]
    if random.work < wanted:
        run.record.notes.append(
            f"the control had time for {random.work} of {wanted} random proposals"
        )


class _Asked:
    """A sampler as what proposes: its own parameters, its failures as ours."""

    def __init__(self, run: Run, sampler: PickingSampler, sampling: dict[str, Any]) -> None:
        self.run, self.sampler, self.sampling = run, sampler, sampling
        self.energy = math.inf
        """Least energy of the assignment's reads; those of a selection are lengths."""

    def __call__(
        self, model: BatchModel, scale: float, reads: int, stop: Stop, seed: int
    ) -> dimod.SampleSet:
        sampling = self.sampling | {"num_reads": reads}
        if "num_reads" not in self.sampler.parameters:
            del sampling["num_reads"]
        parameters = batch_parameters(self.sampler, model, scale, sampling, stop, seed)
        try:
            samples = self.sampler.sample(model.bqm, **parameters)
            samples.resolve()
        except QRobotError:
            raise
        except Exception as error:
            raise BackendError(
                f"backend {self.sampler.name} failed: {type(error).__name__}: {error}"
            ) from error
        if not len(samples) and not stop():
            raise BackendError(f"backend {self.sampler.name} gave no reads")
        if isinstance(model, Assignment) and len(samples):
            self.energy = min(self.energy, float(samples.record.energy.min()))
        return samples
