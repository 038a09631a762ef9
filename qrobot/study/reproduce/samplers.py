"""Rows by our dimod samplers: annealers, and VQE on the SDKs that are installed."""

from __future__ import annotations

from typing import cast

import dimod

from qrobot.backends import get
from qrobot.backends.sampler import PickingSampler
from qrobot.models import build_model
from qrobot.study.reproduce.instances import penalty_model
from qrobot.study.reproduce.outcome import Clock, Line, judged
from qrobot.study.reproduce.question import Question

__all__ = ["anneal", "variational", "warm"]

ALL_STARTS = 16
"""Qubits up to which VQE searches from as many starts as by default; beyond, from one."""

KEPT = (
    "evaluations", "searches", "executions", "optimizer", "ansatz", "layers", "alpha", "device",
    "ground_probability", "ground_probability_uniform",
)  # fmt: skip
"""Facts of a variational run that are reported."""


def _sampler(name: str) -> PickingSampler:
    return cast("PickingSampler", get(name))


def warm(name: str) -> None:
    """Run a sampler once on three variables: imports and just-in-time compilation."""
    sampler = _sampler(name)
    tiny = dimod.BinaryQuadraticModel(
        {"a": 1.0, "b": -1.0, "c": 0.5}, {("a", "b"): 1.0, ("b", "c"): -2.0}, 0.0, "BINARY"
    )
    few = {"evaluations": 4} if "evaluations" in sampler.parameters else {}
    sampler.sample(tiny, num_reads=4, seed=0, **few)


def anneal(line: Line, question: Question, reads: int, seed: int) -> Line:
    """Sample the row's own encoding with the measured penalties and the sampler's settings."""
    sampler, clock = _sampler(line.backend), Clock()
    with clock.timed("build"):
        model = build_model(question.instance, question.row.encoding, slack="paper")
    settings = sampler.picking_defaults(largest_distance=float(question.instance.distances.max()))
    with clock.timed("run"):
        samples = sampler.sample(model.bqm, **(settings | {"num_reads": reads, "seed": seed}))
        samples.resolve()
    with clock.timed("decode"):
        found = model.decode_all(samples)
    line.details = {"penalties": "measured", **settings, "num_reads": reads}
    return judged(line, question, found.distances, clock, seed=seed)


def variational(line: Line, question: Question, reads: int, seed: int) -> Line:
    """Search a circuit's parameters on the penalty form and read its final state."""
    sampler, clock = _sampler(line.backend), Clock()
    with clock.timed("build"):
        model = penalty_model(question.instance, question.row.encoding)
    # Six searches of 18 qubits take several minutes on two cores.
    fewer = {"starts": 1} if model.num_variables > ALL_STARTS else {}
    samples = sampler.sample(model.bqm, num_reads=reads, seed=seed, **fewer)
    spent = samples.info["timing"]
    clock.seconds["build"] += spent["build"]
    clock.seconds["search"], clock.seconds["run"] = spent["optimise"], spent["sample"]
    with clock.timed("decode"):
        found = model.decode_all(samples)
    line.states = 1 << model.num_variables
    line.details = {name: samples.info[name] for name in KEPT if name in samples.info}
    return judged(line, question, found.distances, clock, seed=seed)
