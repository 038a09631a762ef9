"""Plans from a sampler: build, sample, decode, report what it found, repair, polish."""

from __future__ import annotations

import math
import time
from typing import Any

import dimod
import numpy as np

from qrobot.backends import Routes, Stop
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError, InputError, QRobotError
from qrobot.models import PickingModel, build_model
from qrobot.planning.polish import random_routes, repair_and_polish
from qrobot.planning.result import SamplerReport
from qrobot.planning.run import Run

__all__ = ["run_sampler"]

MAX_VARIABLES = 20_000
"""Larger models are refused: their couplings alone would fill a Pi's memory."""

MAX_CELLS = 500_000_000
"""Reads times variables, one byte each: more than this fills a small robot's memory."""

STARTS = 10
"""Reads that are repaired and polished, the best first."""

SAMPLING_SHARE = 0.7
"""Share of the deadline that the sampler may take; decoding, polish, control and the bound
need the rest."""

MODEL_OPTIONS = ("encoding", "slack", "penalties")


def run_sampler(
    run: Run, sampler: PickingSampler, *, control: bool, options: dict[str, Any]
) -> None:
    """Find a plan for a run's instance with a sampler, and report it honestly.

    Parameters
    ----------
    run
        The run; gets the best plan and the sampler's report.
    sampler
        Any dimod sampler of ours.
    control
        Whether to polish as many random starts too.
    options
        `MODEL_OPTIONS` go to the model, everything else to the sampler.

    Raises
    ------
    InputError
        When an option is unknown or the model too large.
    BackendError
        When the sampler fails.
    """
    instance = run.instance
    if not instance.orders:
        run.offer([])
        run.proven = True
        return
    chosen = {name: options[name] for name in MODEL_OPTIONS if name in options}
    sampling = {name: value for name, value in options.items() if name not in MODEL_OPTIONS}
    unknown = sorted(set(sampling) - set(sampler.parameters))
    if unknown:
        raise InputError(
            f"backend {sampler.name} takes no option {', '.join(unknown)}",
            field="backend",
            mend=f"it takes {', '.join(sorted(sampler.parameters))}",
        )
    run.begin(sampler.name)
    _check_size(run, sampler)
    with run.timed("build"):
        model = build_model(instance, **chosen)
    samples = _sample(run, sampler, model, sampling)
    with run.timed("decode"):
        feasible, costs = model.decode_all(samples)
        report = _report(sampler, model, samples, feasible, costs)
        starts = _starts(model, samples, feasible, costs)
    run.sampler = report
    if report.best is not None:
        run.offer(starts[0])
    with run.timed("polish"):
        report.polished_best, _ = _polish(run, starts)
        if control:
            rng = np.random.default_rng(run.seed)
            random = [random_routes(instance, rng) for _ in starts]
            # The control must not improve the plan that it is the control of.
            report.control_best, report.control_mean = _polish(run, random, keep=False)
    run.tell()


def _check_size(run: Run, sampler: PickingSampler) -> None:
    # Every encoding has at least one variable for an item and a step of each robot.
    instance = run.instance
    least = instance.size * max(instance.size // max(len(instance.vehicle_capacities), 1), 1)
    limit = min(sampler.capabilities.max_size or MAX_VARIABLES, MAX_VARIABLES)
    if least > limit:
        raise InputError(
            f"{instance.size} items need a model of more than {least} binary variables, "
            f"backend {sampler.name} takes {limit}",
            field="backend",
            mend="use backend auto, or plan fewer items at a time",
        )


def _sample(
    run: Run, sampler: PickingSampler, model: PickingModel, options: dict[str, Any]
) -> dimod.SampleSet:
    largest = float(run.instance.place_distances.max(initial=0.0)) or 1.0
    parameters = sampler.picking_defaults(largest_distance=largest) | options
    if "seed" in sampler.parameters:
        parameters.setdefault("seed", run.seed)
    if "interrupt_function" in sampler.parameters:
        left = run.stop.remaining
        part = run.stop.within(SAMPLING_SHARE * left if math.isfinite(left) else None)
        parameters.setdefault("interrupt_function", part)
    if run.stop.max_work is not None and "num_reads" in sampler.parameters:
        parameters["num_reads"] = min(parameters.get("num_reads", 100), run.stop.max_work)
    reads = parameters.get("num_reads")
    if isinstance(reads, int) and reads * model.num_variables > MAX_CELLS:
        raise InputError(
            f"{reads} reads of {model.num_variables} variables do not fit into memory",
            field="num_reads",
            mend=f"use at most {MAX_CELLS // model.num_variables}",
        )
    begun = time.perf_counter()
    try:
        samples = sampler.sample(model.bqm, **parameters)
        samples.resolve()
    except QRobotError:
        raise
    except Exception as error:
        raise BackendError(
            f"backend {sampler.name} failed: {type(error).__name__}: {error}"
        ) from error
    run.timing.run += time.perf_counter() - begun
    run.work[sampler.name] = len(samples)
    return samples


def _report(
    sampler: PickingSampler,
    model: PickingModel,
    samples: dimod.SampleSet,
    feasible: Any,
    costs: Any,
) -> SamplerReport:
    times = samples.record.num_occurrences.astype(np.float64)
    reads = float(times.sum())
    found = costs[feasible]
    return SamplerReport(
        backend=sampler.name,
        encoding=model.encoding,
        variables=model.num_variables,
        reads=int(reads),
        feasible_fraction=float(times[feasible].sum() / reads) if reads else 0.0,
        best=float(found.min()) if found.size else None,
        mean=float(np.average(found, weights=times[feasible])) if found.size else None,
        energy=float(samples.record.energy.min()) if len(samples) else float("nan"),
    )


def _starts(
    model: PickingModel, samples: dimod.SampleSet, feasible: Any, costs: Any
) -> list[Routes]:
    """Return the routes of the best reads: feasible ones by distance, then by energy."""
    order = np.lexsort((np.where(feasible, costs, samples.record.energy), ~feasible))
    names = list(samples.variables)
    rows = samples.record.sample[order[:STARTS]]
    return [model.decode(dict(zip(names, row.tolist(), strict=True))).routes for row in rows]


def _polish(
    run: Run, starts: list[Routes], *, keep: bool = True
) -> tuple[float | None, float | None]:
    """Repair and polish starts; return the best and the mean distance."""
    lengths = []
    for number, start in enumerate(starts):
        if number and run.stop():
            break
        routes = repair_and_polish(run.instance, start, _short(run.stop), run.seed + number)
        if routes is None:
            continue
        lengths.append(run.instance.length(routes))
        if keep:
            run.offer(routes)
    if not lengths:
        return None, None
    return min(lengths), float(np.mean(lengths))


def _short(stop: Stop) -> Stop:
    """Return a stop that allows at least a first repair, even when time is up."""
    return stop if not stop() else Stop(max_work=1)
