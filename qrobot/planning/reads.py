"""Reads from a sampler: its parameters, its share of the deadline, where its time went.

The measured weights let an annealer move, and their lowest energy need not be a plan: a robot
that carries a little too much is cheap. A sampler that only looks for the lowest energy then
never gives a plan. So while no read is a plan, the weight of what the best read breaks is
raised, and the sampler is asked again; every read is still its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import dimod
import numpy as np

from qrobot._parameters import Parameter
from qrobot.backends import Stop
from qrobot.backends.sampler import PickingSampler, check_parameters
from qrobot.errors import BackendError, InputError, QRobotError
from qrobot.jobs import redact, timing_fields
from qrobot.models import Penalties, PickingModel, build_model
from qrobot.planning.run import Run
from qrobot.planning.strategy import ARGUMENTS, MODEL_OPTIONS
from qrobot.problem.formats.native import to_text

__all__ = [
    "ROUNDS",
    "call_parameters",
    "parameters_of",
    "sample_in_rounds",
    "split_options",
    "take_reads",
]

MAX_CELLS = 500_000_000
"""Reads times variables, one byte each: more than this fills a small robot's memory."""

SAMPLING_SHARE = 0.7
"""Share of the deadline that the sampler may take; decoding, polish, control and the bound
need the rest."""

AFTERWARDS = 10.0
"""Seconds for repair, polish and bound when a remote answer was awaited without a deadline."""

ROUNDS = 8
"""Most rounds of a local sampler; a remote one has one by default, because each bills."""

HEAVIER, FIRMER = 2.0, 1.5
"""Growth of the capacity weight a round, and of the others."""


def split_options(
    sampler: PickingSampler, options: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the options of the model and those of the sampler.

    Raises
    ------
    InputError
        When neither takes an option, or not this value.
    """
    Parameter("whole", 1).check("rounds", options.get("rounds"))
    chosen = {name: options[name] for name in MODEL_OPTIONS if name in options}
    own = (*MODEL_OPTIONS, "rounds")
    sampling = {name: value for name, value in options.items() if name not in own}
    check_parameters(sampler, sampling, also=(*ARGUMENTS, *own))
    return chosen, sampling


def context_of(run: Run, chosen: dict[str, Any]) -> dict[str, Any]:
    """Return what is kept beside a remote job, so that its answer becomes a plan later."""
    try:
        text = to_text(run.instance)
    except InputError:  # a weight such as one third: the answer stays, without a plan
        return {}
    weights = chosen.get("penalties")
    if isinstance(weights, Penalties):
        chosen = chosen | {"penalties": asdict(weights)}
    objective = run.best.objective.name
    return {"instance": text, "model": chosen, "seed": run.seed, "objective": objective}


def take_reads(
    run: Run,
    sampler: PickingSampler,
    model: PickingModel,
    chosen: dict[str, Any],
    sampling: dict[str, Any],
) -> dimod.SampleSet:
    """Sample a model within a run's deadline; its timing gets the seconds of each part.

    Parameters
    ----------
    run
        The run.
    sampler, model
        Who samples what.
    chosen
        The options that the model was built with, kept beside a remote job.
    sampling
        The sampler's own.

    Raises
    ------
    InputError
        When there are too many reads for the memory.
    BackendError
        When the sampler fails.
    """
    parameters = parameters_of(sampler, model, sampling, run.stop, run.seed)
    if "context" in sampler.parameters and sampler.runs_remotely(**sampling):
        parameters.setdefault("context", context_of(run, chosen))
    begun = time.perf_counter()
    try:
        samples = sampler.sample(model.bqm, **parameters)
        samples.resolve()
    except QRobotError:
        raise
    except Exception as error:
        text = redact(f"{type(error).__name__}: {error}")
        # Errors of remote SDKs may quote a token: their chain stays here.
        cause = None if sampler.runs_remotely(**sampling) else error
        raise BackendError(f"backend {sampler.name} failed: {text}") from cause
    parts = timing_fields(samples.info)
    # A remote device tells its own work; a local one's is all that we waited for.
    parts.setdefault("run", time.perf_counter() - begun)
    asked = sampling.get("num_reads")
    if isinstance(asked, int) and asked > parameters["num_reads"]:
        allowed = parameters["num_reads"]
        note = f"{sampler.name}: the limit of work allows {allowed} of {asked} reads"
        run.record.notes.append(note)
    _tell_cut(run, sampler.name, samples, parameters)
    for name, seconds in parts.items():
        setattr(run.record.timing, name, getattr(run.record.timing, name) + seconds)
    if sampler.runs_remotely(**sampling) and math.isinf(run.stop.remaining):
        run.stop = Stop(AFTERWARDS, run.stop.max_work, parent=run.stop)
    run.record.work[sampler.name] = len(samples)
    return samples


def _tell_cut(run: Run, name: str, samples: dimod.SampleSet, parameters: dict[str, Any]) -> None:
    """Say so when a sampler was stopped before it had done its work."""
    if (cut := samples.info.get("cut")) is not None:
        run.record.notes.append(f"{name}: {cut}")
    part = parameters.get("interrupt_function")
    if not isinstance(part, Stop) or part.remaining > 0:
        return
    taken, wanted = int(samples.record.num_occurrences.sum()), parameters.get("num_reads")
    if cut is None and isinstance(wanted, int) and taken < wanted and not part.requested:
        run.record.notes.append(
            f"{name} took {taken} of {wanted} reads in its share of the deadline, "
            f"{SAMPLING_SHARE:.0%}"
        )
    run.out_of_time |= cut is not None or (isinstance(wanted, int) and taken < wanted)


def parameters_of(
    sampler: PickingSampler,
    model: PickingModel,
    sampling: dict[str, Any],
    stop: Stop,
    seed: int,
) -> dict[str, Any]:
    """Return what a sampler is called with: its defaults for picking, and what was asked.

    Raises
    ------
    InputError
        When the reads do not fit into the memory.
    """
    d = model.instance.place_distances
    useful = d <= model.instance.longest_useful
    largest = float(d.max(initial=0.0, where=useful & np.isfinite(d))) or 1.0
    left = stop.remaining
    part = stop.within(SAMPLING_SHARE * left if math.isfinite(left) else None)
    parameters = call_parameters(sampler, largest, sampling, part, seed)
    if stop.max_work is not None and "num_reads" in sampler.parameters:
        parameters["num_reads"] = min(parameters.get("num_reads") or 100, stop.max_work)
    reads = parameters.get("num_reads")
    if isinstance(reads, int) and reads * model.num_variables > MAX_CELLS:
        raise InputError(
            f"{reads} reads of {model.num_variables} variables do not fit into memory",
            field="num_reads",
            advice=f"use at most {MAX_CELLS // model.num_variables}",
        )
    return parameters


def call_parameters(
    sampler: PickingSampler,
    scale: float,
    sampling: Mapping[str, Any],
    stop: Stop,
    seed: int,
) -> dict[str, Any]:
    """Return a sampler's defaults for a scale of energies, and what it is asked for."""
    parameters = sampler.picking_defaults(largest_distance=scale) | dict(sampling)
    if "seed" in sampler.parameters:
        parameters.setdefault("seed", seed)
    if "interrupt_function" in sampler.parameters:
        parameters.setdefault("interrupt_function", stop)
    return parameters


def sample_in_rounds(
    run: Run,
    sampler: PickingSampler,
    model: PickingModel,
    chosen: dict[str, Any],
    sampling: dict[str, Any],
    most: int | None = None,
) -> tuple[PickingModel, dimod.SampleSet, int, int]:
    """Sample a model until a read is a plan, or the rounds, the time or the work are over.

    Parameters
    ----------
    run, sampler, model, chosen, sampling
        As of `take_reads`. Weights that the caller chose are never changed.
    most
        Most rounds; ``None``: `ROUNDS` of a local sampler, 1 of a remote one.

    Returns
    -------
    model
        The one of the last round.
    samples
        Of the last round; those before held no plan.
    reads
        Of all rounds together.
    rounds
        How many there were.
    """
    remote = sampler.runs_remotely(**sampling)
    most = (1 if remote else ROUNDS) if most is None else most
    if chosen.get("penalties") == "measured":  # the default, by name
        chosen = {name: value for name, value in chosen.items() if name != "penalties"}
    if "penalties" in chosen:
        most = 1
    total = rounds = 0
    kept: tuple[PickingModel, dimod.SampleSet] | None = None
    while True:
        try:
            samples = take_reads(run, sampler, model, chosen, sampling)
        except BackendError as error:
            if kept is None:
                raise
            # The reads of the rounds before may have been paid for.
            run.record.notes.append(f"round {rounds + 1} of {sampler.name} failed: {error}")
            return *kept, total, rounds
        kept = model, samples
        rounds += 1
        total += int(samples.record.num_occurrences.sum())
        limit = run.stop.max_work
        over = run.stop() or rounds == most or (limit is not None and total >= limit)
        if over or not len(samples):
            return model, samples, total, rounds
        with run.timed("decode"):
            feasible, _ = model.decode_all(samples)
        if feasible.any():
            return model, samples, total, rounds
        if remote and "max_cost" in sampling:
            sampling = sampling | {"max_cost": max(0.0, sampling["max_cost"] - _usd(samples))}
        with run.timed("build"):
            model = build_model(run.instance, **chosen, penalties=_raised(model, samples))


def _usd(samples: dimod.SampleSet) -> float:
    """Return what a round was estimated to cost: a limit holds for all rounds together."""
    # A search on the device tells the cost of all its jobs, the reads among them.
    job = samples.info.get("search") or samples.info.get("remote") or {}
    return float(job.get("estimate", {}).get("usd") or 0.0)


def _raised(model: PickingModel, samples: dimod.SampleSet) -> Penalties:
    """Return the weights with those raised that the read of least energy breaks."""
    row = samples.record.sample[int(samples.record.energy.argmin())]
    best = dict(zip(samples.variables, row.tolist(), strict=True))
    kinds = {violation.kind for violation in model.decode(best).violations}
    weights = model.penalties
    if "capacity" in kinds:
        weights = replace(weights, capacity=weights.capacity * HEAVIER)
    if kinds - {"capacity"}:
        weights = replace(
            weights,
            step=weights.step * FIRMER,
            visit=weights.visit * FIRMER,
            same_robot=weights.same_robot * FIRMER,
        )
    return weights
