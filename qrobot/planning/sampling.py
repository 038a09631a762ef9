"""Plans from a sampler: build, sample, decode, report what it found, repair, polish."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import dimod
import numpy as np

from qrobot.backends import Routes, Stop
from qrobot.backends.classical.batching import SearchData, batches_of, ruin_and_recreate
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError, InputError
from qrobot.jobs import json_data, redact_data
from qrobot.models import PickingModel, build_model
from qrobot.models.layout import MAX_VARIABLES
from qrobot.planning.batch_sampling import plan_batches, wants_batches
from qrobot.planning.reads import sample_in_rounds, split_options
from qrobot.planning.result import SamplerReport
from qrobot.planning.run import Run
from qrobot.planning.strategy import MODEL_OPTIONS, Strategy
from qrobot.problem import Instance

__all__ = ["SamplerStrategy", "build", "random_routes", "repair_and_polish", "use_reads"]

SHARED_OPTIONS = (*MODEL_OPTIONS, "num_reads", "seed")
"""Options that mean the same to every sampler."""

STARTS = 10
"""Reads that are repaired and polished, the best first."""

POLISH_ROUNDS = 30
"""Rounds of ruin and recreate for each start."""

RANDOM_BLOCK = 1000
"""Random reads that are judged at once."""

LONGEST = 200
"""Longer lists, such as a search's history, stay out of the report; the sample set has them."""


class SamplerStrategy(Strategy):
    """A sampler as a planner: model, reads in rounds, decode, repair, polish.

    Parameters
    ----------
    sampler
        Any dimod sampler of ours.
    """

    def __init__(self, sampler: PickingSampler) -> None:
        self.sampler: PickingSampler = sampler
        self.name = sampler.name
        self.capabilities = replace(sampler.capabilities, kind="planner", control=True)
        self._options: dict[str, Any] = {}
        self._control = False

    def take(
        self, options: Mapping[str, Any], *, control: bool = False, max_cost: float | None = None
    ) -> None:
        """Take the options; a limit of the cost goes to a sampler that bills."""
        super().take(options, control=control)
        self._options, self._control = dict(options), control
        if max_cost is not None and self.sampler.runs_remotely(**options):
            self._options["max_cost"] = max_cost

    def check_options(self, options: Mapping[str, Any]) -> None:
        """Refuse what neither the model nor the sampler takes."""
        split_options(self.sampler, options)

    def known_options(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return the options that mean the same to every sampler, where this one takes them."""
        known = {*SHARED_OPTIONS} & {*MODEL_OPTIONS, *self.sampler.parameters}
        return {key: value for key, value in options.items() if key in known}

    def limits(self, stop: Stop) -> Stop:
        """Wait for a remote sampler without limit: nobody knows how long its queue is."""
        return stop if self.sampler.runs_remotely(**self._options) else super().limits(stop)

    def plan(self, run: Run) -> None:
        """Find a plan from reads, and report honestly what they are by themselves.

        Raises
        ------
        InputError
            When an option is unknown or the model too large.
        BackendError
            When the sampler fails.
        """
        instance, sampler, options = run.instance, self.sampler, self._options
        if not instance.orders:
            run.best.offer([])
            run.best.proven = True
            return
        for name, flag in (("wait", "submit"), ("dry_run", "estimate")):
            if name in options:
                raise InputError(
                    f"{name} belongs to qrobot.planning.{flag}",
                    field=name,
                    advice=f"use that, or --{'no-wait' if name == 'wait' else 'dry-run'}",
                )
        if wants_batches(instance, sampler, options, run.stop):
            plan_batches(run, sampler, options, control=self._control)
            return
        chosen, sampling = split_options(sampler, options)
        run.begin(sampler.name)
        with run.timed("build"):
            model = build(instance, sampler, chosen)
        model, samples, reads, rounds = sample_in_rounds(
            run, sampler, model, chosen, sampling, options.get("rounds")
        )
        if not len(samples):
            raise BackendError(f"backend {sampler.name} gave no reads")
        run.record.work[sampler.name] = reads
        use_reads(
            run, sampler.name, model, samples, reads=reads, rounds=rounds, control=self._control
        )


def build(instance: Instance, sampler: PickingSampler, chosen: dict[str, Any]) -> PickingModel:
    """Return the model of an instance, with the chosen options, unless it is too large to sample.

    Raises
    ------
    InputError
        When the model is too large, or an option cannot be used.
    """
    # Every encoding has at least one variable for an item and a step of each robot.
    least = instance.size * max(instance.size // max(len(instance.vehicle_capacities), 1), 1)
    limit = min(sampler.capabilities.max_size or MAX_VARIABLES, MAX_VARIABLES)
    if least > limit:
        raise InputError(
            f"{instance.size} items need a model of more than {least} binary variables, "
            f"backend {sampler.name} takes {limit}",
            field="backend",
            advice="use backend auto, or plan fewer items at a time",
        )
    return build_model(instance, **chosen)


def use_reads(
    run: Run,
    name: str,
    model: PickingModel,
    samples: dimod.SampleSet,
    *,
    reads: int | None = None,
    rounds: int = 1,
    control: bool = False,
) -> None:
    """Report what reads are by themselves, then repair and polish the best of them.

    Parameters
    ----------
    run
        The run; gets the best plan and the sampler's report.
    name
        Of the backend that the reads came from.
    model, samples
        The model, and its reads.
    reads, rounds
        Of all rounds; the rounds before the last held no plan.
    control
        Whether to look at as many random reads, and to polish as many random starts.
    """
    rng = np.random.default_rng(run.seed)
    with run.timed("decode"):
        feasible, costs = model.decode_all(samples)
        report = _report(name, model, samples, feasible, costs, reads)
        report.rounds = rounds
        starts = _starts(model, samples, feasible, costs)
        times = samples.record.num_occurrences.astype(np.float64)
        run.record.reads = (np.repeat(costs[feasible], times[feasible].astype(int)), None)
        if control:
            random_costs = _random_reads(model, report.reads, rng)
            report.random_feasible_fraction = random_costs.size / max(report.reads, 1)
            report.random_best = float(random_costs.min()) if random_costs.size else None
            run.record.reads = (run.record.reads[0], random_costs)
    run.record.sampler = report
    if report.best is not None:
        run.best.offer(starts[0])
    with run.timed("polish"):
        report.polished_best, _ = _polish(run, starts)
        if control:
            random = [random_routes(run.instance, rng) for _ in starts]
            # The control must not improve the plan that it is the control of.
            report.control_best, report.control_mean = _polish(run, random, keep=False)
    run.tell()


def _random_reads(model: PickingModel, reads: int, rng: np.random.Generator) -> Any:
    """Return the distances of the feasible ones among as many uniformly random reads."""
    found = []
    for begin in range(0, reads, RANDOM_BLOCK):
        count = min(RANDOM_BLOCK, reads - begin)
        bits = rng.integers(0, 2, (count, model.num_variables), dtype=np.int8)
        samples = dimod.SampleSet.from_samples(
            (bits, model.variables), vartype="BINARY", energy=np.zeros(count)
        )
        feasible, costs = model.decode_all(samples)
        found.append(costs[feasible])
    return np.concatenate(found) if found else np.zeros(0)


def _report(
    name: str,
    model: PickingModel,
    samples: dimod.SampleSet,
    feasible: Any,
    costs: Any,
    taken: int | None,
) -> SamplerReport:
    times = samples.record.num_occurrences.astype(np.float64)
    reads = float(times.sum()) if taken is None else float(taken)
    found = costs[feasible]
    return SamplerReport(
        backend=name,
        encoding=model.encoding,
        variables=model.num_variables,
        reads=int(reads),
        feasible_fraction=float(times[feasible].sum() / reads) if reads else 0.0,
        best=float(found.min()) if found.size else None,
        mean=float(np.average(found, weights=times[feasible])) if found.size else None,
        energy=float(samples.record.energy.min()) if len(samples) else float("nan"),
        details=details_of(samples.info),
    )


def details_of(info: Any) -> dict[str, Any]:
    """Return what a sampler tells of itself as plain data: parameters, embedding, job."""
    facts = redact_data(json_data(dict(info)))
    kept = {k: v for k, v in facts.items() if not (isinstance(v, list) and len(v) > LONGEST)}
    kept.pop("history", None)
    return kept


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
            run.best.offer(routes)
    if not lengths:
        return None, None
    return min(lengths), float(np.mean(lengths))


def _short(stop: Stop) -> Stop:
    """Return a stop that allows at least a first repair, even when time is up."""
    return stop if not stop() else Stop(max_work=1)


def repair_and_polish(
    instance: Instance, start: Routes, stop: Stop, seed: int, rounds: int = POLISH_ROUNDS
) -> Routes | None:
    """Return a valid plan made from any routes, or None when no room or way was found.

    Repair keeps every order that was collected whole and within a robot's capacity, and inserts
    the rest where it costs least. Polish is ruin and recreate.

    Parameters
    ----------
    instance, stop, seed
        As of `Planner.search`.
    start
        Routes of nodes; may leave out, repeat, split or overload.
    rounds
        Rounds of polish; 0 repairs only.
    """
    data = SearchData(instance, seed, stop)
    state = batches_of(data, start)
    routes = ruin_and_recreate(data, state, stop.within(max_work=rounds))
    return None if routes is None or math.isinf(instance.length(routes)) else routes


def random_routes(instance: Instance, rng: np.random.Generator) -> Routes:
    """Return orders dealt to trips at random, in random sequence; loads are not looked at."""
    trips: Routes = [[] for _ in instance.vehicle_capacities]
    for order in rng.permutation(len(instance.orders)).tolist():
        nodes = list(instance.order_nodes[order])
        rng.shuffle(nodes)
        trips[int(rng.integers(len(trips)))].extend(nodes)
    return trips
