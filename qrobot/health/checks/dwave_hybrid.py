"""dwave-hybrid: a workflow that takes a model apart, improves the parts and puts them back."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that the workflow tells, and that of its state in numpy."""
    import dimod

    hybrid: Any = importlib.import_module("hybrid")
    model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
    part = (
        hybrid.Const(subsamples=None)  # those of the last round are of other spins
        | hybrid.EnergyImpactDecomposer(size=6)
        | hybrid.TabuSubproblemSampler(timeout=20)
        | hybrid.SplatComposer()
    )
    whole = hybrid.TabuProblemSampler(timeout=100)
    workflow = hybrid.Loop(hybrid.Parallel(part, whole) | hybrid.ArgMin(), max_iter=3)
    start = hybrid.State.from_sample(dict.fromkeys(range(len(known.FIELDS)), 1), model)
    best = workflow.run(start).result().samples.first
    state = np.array([[best.sample[k] for k in range(len(known.FIELDS))]])
    return [float(best.energy), float(known.energies(state)[0])]


CHECK = Check(
    module=__name__,
    title="a hybrid workflow, 8 spins",
    group="annealing",
    imports=("hybrid",),
    distributions=("dwave-hybrid",),
    answer=answer,
    expected=known.ground_expected,
    source="all 256 states in numpy",
    extra="dwave",
)
