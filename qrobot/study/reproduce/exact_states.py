"""Rows by QAOA whose exact state is simulated here: penalty form, swap and Grover mixer.

No search is told the optimum: angles are tuned on the mean, then on the mean of the best
share; then the state is read as often as every other method.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import dimod
import numpy as np

from qrobot.backends.gate import (
    DiagonalQAOA,
    Form,
    SubspaceQAOA,
    Tuning,
    bits_of,
    feasible_set,
    sharpen,
    spectrum,
)
from qrobot.backends.gate.tune import SHARPER
from qrobot.errors import BackendError
from qrobot.models import PickingModel
from qrobot.study.reproduce.instances import paper_instance, penalty_model, table_instance
from qrobot.study.reproduce.left import Left
from qrobot.study.reproduce.outcome import Clock, Line, judged
from qrobot.study.reproduce.paper import PaperRow
from qrobot.study.reproduce.question import Question, same

__all__ = ["grover", "penalty", "swap", "warm"]

SWAP_LAYERS, GROVER_LAYERS = 4, 10
SMALL = 5
"""Items of the instance on which the swap mixer's first angles are found."""


def warm(name: str) -> None:  # noqa: ARG001 - as of samplers
    """Compile, or load what was compiled."""
    form = Form.from_bqm(penalty_model(paper_instance(3)).bqm)
    DiagonalQAOA(form, alpha=0.5).value(np.array([0.1]), np.array([0.1]))


def penalty(line: Line, question: Question, reads: int, seed: int) -> Line:
    """Read the state of one layer of penalty-form QAOA on the row's own encoding.

    Raises
    ------
    Left
        When memory is too small for the state.
    """
    clock = Clock()
    with clock.timed("build"):
        model = penalty_model(question.instance, question.row.encoding)
        form = Form.from_bqm(model.bqm)
        try:
            qaoa = DiagonalQAOA(form)
        except BackendError as error:  # refused before anything is allocated
            raise Left(str(error)) from None
    with clock.timed("search"):
        found = sharpen(qaoa, 1, evaluations=12, alphas=(0.1, 0.01))
    with clock.timed("run"):
        qaoa.run(found.gammas, found.betas)
        drawn = qaoa.sample(reads, np.random.default_rng(seed))
    with clock.timed("decode"):
        samples = dimod.SampleSet.from_samples_bqm(
            (bits_of(drawn, form.qubits), list(form.variables)), model.bqm
        )
        distances = model.decode_all(samples).distances
    indices = _optimal(model, question, form.variables)
    line.probability = float(qaoa.probabilities(indices).sum())
    line.states = 1 << form.qubits
    line.details = {**_angles(found, qaoa.spread), "layers": 1, "engine": qaoa.engine.name}
    return judged(line, question, distances, clock, seed=seed)


def swap(line: Line, question: Question, reads: int, seed: int) -> Line:
    """Read the state of the swap mixer on the enumerated plans.

    The first angles come from an instance of five items; its search is in the seconds.
    """
    clock = Clock()
    with clock.timed("build"):
        plans = feasible_set(question.instance)
        qaoa = SubspaceQAOA.of(plans, "swap")
    with clock.timed("search"):
        start = _first_angles(question.row, qaoa.spread, seed)
        found = sharpen(qaoa, SWAP_LAYERS, evaluations=30, alphas=(1.0, 0.1), start=start)
    with clock.timed("run"):
        p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
        drawn = np.random.default_rng(seed).choice(len(p), reads, p=p / p.sum())
    with clock.timed("decode"):
        distances = plans.costs[drawn]
    line.probability = float(p[same(plans.costs, question.optimum)].sum())
    line.states = plans.size
    line.details = {**_angles(found, qaoa.spread), "layers": SWAP_LAYERS}
    return judged(line, question, distances, clock, seed=seed, plans_only=True)


def grover(line: Line, question: Question, reads: int, seed: int) -> Line:
    """Read the state of the Grover mixer, one amplitude a distance.

    Counting the plans by distance is this method's build; the question did it already, so
    it is done once more for the clock.
    """
    clock = Clock()
    with clock.timed("build"):
        counted = spectrum(question.instance)
        qaoa = counted.qaoa()
    with clock.timed("search"):
        found = sharpen(qaoa, GROVER_LAYERS, evaluations=200, alphas=SHARPER)
    with clock.timed("run"):
        p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
        distances = np.random.default_rng(seed).choice(counted.levels, reads, p=p / p.sum())
    line.probability = float(p[same(counted.levels, question.optimum)].sum())
    line.states = counted.size
    line.details = {**_angles(found, qaoa.spread), "layers": GROVER_LAYERS}
    return judged(line, question, distances, clock, seed=seed, plans_only=True)


def _first_angles(
    row: PaperRow, spread: float, seed: int
) -> tuple[Sequence[float], Sequence[float]]:
    small = PaperRow(row.table, 1, SMALL, row.capacity, 0, {})
    qaoa = SubspaceQAOA.of(feasible_set(table_instance(small, seed)), "swap")
    found = sharpen(qaoa, SWAP_LAYERS, evaluations=60, alphas=(1.0, 0.1))
    return [gamma * qaoa.spread / spread for gamma in found.gammas], found.betas


def _angles(found: Tuning, spread: float) -> dict[str, object]:
    return {
        "gammas": [gamma * spread for gamma in found.gammas],  # in units of 1 / spread
        "betas": list(found.betas),
        "evaluations": found.evaluations,
    }


def _optimal(
    model: PickingModel, question: Question, variables: Sequence[object]
) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the indices of all assignments that decode to an optimal plan.

    The slack bits do not matter to what a read says, so each of their values counts.
    """
    instance, places = question.instance, model.layout.places
    at = [1 << list(variables).index(label) for label in model.variables]
    found = []
    for tour in permutations(range(1, instance.size + 1)):
        if same(np.array([instance.length([list(tour)])]), question.optimum)[0]:
            bits = model.encode_bits([list(tour)])[:places]
            base = sum(weight for weight, bit in zip(at, bits.tolist(), strict=False) if bit)
            slack = np.zeros(1, dtype=np.intp)
            for weight in at[places:]:
                slack = np.concatenate([slack, slack + weight])
            found.append(base + slack)
    return np.concatenate(found)
