"""Reads from a sampler: its parameters, its share of the deadline, where its time went."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import dimod
import numpy as np

from qrobot.backends import Stop
from qrobot.backends.sampler import PickingSampler, check_parameters
from qrobot.errors import BackendError, InputError, QRobotError
from qrobot.jobs import redact, timing_fields
from qrobot.models import Penalties, PickingModel
from qrobot.planning.arguments import ARGUMENTS, MODEL_OPTIONS, ROUNDS
from qrobot.planning.run import Run
from qrobot.problem import Instance
from qrobot.problem.formats.native import to_text

__all__ = ["AFTERWARDS", "parameters_of", "split_options", "take_reads"]

MAX_CELLS = 500_000_000
"""Reads times variables, one byte each: more than this fills a small robot's memory."""

SAMPLING_SHARE = 0.7
"""Share of the deadline that the sampler may take; decoding, polish, control and the bound
need the rest."""

AFTERWARDS = 10.0
"""Seconds for repair, polish and bound when a remote answer was awaited without a deadline."""


def split_options(
    sampler: PickingSampler, options: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the options of the model and those of the sampler.

    Raises
    ------
    InputError
        When neither takes an option, or not this value.
    """
    ROUNDS.check("rounds", options.get("rounds"))
    chosen = {name: options[name] for name in MODEL_OPTIONS if name in options}
    own = (*MODEL_OPTIONS, "rounds")
    sampling = {name: value for name, value in options.items() if name not in own}
    check_parameters(sampler, sampling, also=(*ARGUMENTS, *own))
    return chosen, sampling


def context_of(instance: Instance, chosen: dict[str, Any], seed: int) -> dict[str, Any]:
    """Return what is kept beside a remote job, so that its answer becomes a plan later."""
    try:
        text = to_text(instance)
    except InputError:  # a weight such as one third: the answer stays, without a plan
        return {}
    weights = chosen.get("penalties")
    if isinstance(weights, Penalties):
        chosen = chosen | {"penalties": asdict(weights)}
    return {"instance": text, "model": chosen, "seed": seed}


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
        parameters.setdefault("context", context_of(run.instance, chosen, run.seed))
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
    parameters = sampler.picking_defaults(largest_distance=largest) | sampling
    if "seed" in sampler.parameters:
        parameters.setdefault("seed", seed)
    if "interrupt_function" in sampler.parameters:
        left = stop.remaining
        part = stop.within(SAMPLING_SHARE * left if math.isfinite(left) else None)
        parameters.setdefault("interrupt_function", part)
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
