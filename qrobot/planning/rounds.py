"""Reads in rounds: while no read is a plan, raise the weight that was broken and sample again.

The measured weights let an annealer move, and their lowest energy may be no plan: a robot
that carries a little too much is cheap. A sampler that only looks for the lowest energy then
never gives a plan. Raising the weight of what its best read breaks mends that; every read is
still the sampler's own.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import dimod

from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError
from qrobot.models import Penalties, PickingModel, build_model
from qrobot.planning.reads import take_reads
from qrobot.planning.run import Run

__all__ = ["ROUNDS", "sample_in_rounds"]

ROUNDS = 8
"""Most rounds of a local sampler; a remote one has one by default, because each bills."""

HEAVIER, FIRMER = 2.0, 1.5
"""Growth of the capacity weight a round, and of the others."""


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
    told = samples.info.get("search") or samples.info.get("remote") or {}
    return float(told.get("estimate", {}).get("usd") or 0.0)


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
