"""Our methods for a row of the paper: which can run, and how each is run.

Annealers and VQE run through our samplers. Of QAOA (penalty form, swap and Grover mixer) the exact
state is simulated here: no search is told the optimum, angles are tuned on the mean, then on the
mean of the best share; then the state is read as often as every other method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import permutations
from typing import cast

import dimod
import numpy as np

from qrobot._arrays import Floats
from qrobot.backends import get
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
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError
from qrobot.models import PickingModel, build_model
from qrobot.study.reproduce.paper import (
    ENUMERATED,
    PaperRow,
    paper_instance,
    penalty_model,
    table_instance,
)
from qrobot.study.reproduce.question import Clock, Outcome, Question, judged, same

__all__ = [
    "ANNEALERS", "LARGE_QUBITS", "METHODS", "QUBITS", "VQES", "CannotRun", "Method", "methods_for",
]  # fmt: skip

ANNEALERS = ("neal", "tabu", "descent")
VQES = ("qiskit-vqe", "pennylane-vqe", "braket-vqe")

QUBITS, LARGE_QUBITS = 24, 26
"""Most qubits of the penalty form, as a matter of course and with ``--large``."""

VQE_QUBITS = 18

SWAP_LAYERS, GROVER_LAYERS = 4, 10
SMALL = 5
"""Items of the instance on which the swap mixer's first angles are found."""

ALL_STARTS = 16
"""Qubits up to which VQE searches from as many starts as by default; beyond, from one."""

KEPT = (
    "evaluations", "searches", "executions", "optimizer", "ansatz", "layers", "alpha", "device",
    "ground_probability", "ground_probability_uniform",
)  # fmt: skip
"""Facts of a variational run that are reported."""


class CannotRun(Exception):  # noqa: N818 - the reason stands in the table: nothing has failed
    """A method cannot run on a row here; the text says why."""


Run = Callable[[Outcome, Question, int, int], Outcome]


@dataclass(frozen=True, slots=True)
class Method:
    """A way to fill a cell of the paper's tables.

    Parameters
    ----------
    name
        As reported.
    backend
        What runs: a backend of ours, or the simulator of `qrobot.backends.gate`.
    label
        Column title.
    run
        Fills an outcome from a row's question, a number of reads and a seed. Raises `CannotRun`
        with a reason, MissingExtraError where software is missing, BackendError when it fails.
    warm
        Imports and compiles what the method needs, outside of every clock.
    """

    name: str
    backend: str
    label: str
    run: Run
    warm: Callable[[], None]


def _sampler(name: str) -> PickingSampler:
    return cast("PickingSampler", get(name))


def _warm_sampler(name: str) -> None:
    """Run a sampler once on three variables: imports and just-in-time compilation."""
    sampler = _sampler(name)
    tiny = dimod.BinaryQuadraticModel(
        {"a": 1.0, "b": -1.0, "c": 0.5}, {("a", "b"): 1.0, ("b", "c"): -2.0}, 0.0, "BINARY"
    )
    few = {"evaluations": 4} if "evaluations" in sampler.parameters else {}
    sampler.sample(tiny, num_reads=4, seed=0, **few)


def _anneal(line: Outcome, question: Question, reads: int, seed: int) -> Outcome:
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


def _variational(line: Outcome, question: Question, reads: int, seed: int) -> Outcome:
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


def _warm_simulator() -> None:
    """Compile, or load what was compiled."""
    form = Form.from_bqm(penalty_model(paper_instance(3)).bqm)
    DiagonalQAOA(form, alpha=0.5).value(np.array([0.1]), np.array([0.1]))


def _penalty(line: Outcome, question: Question, reads: int, seed: int) -> Outcome:
    """Read the state of one layer of penalty-form QAOA on the row's own encoding.

    Raises
    ------
    CannotRun
        When memory is too small for the state.
    """
    clock = Clock()
    with clock.timed("build"):
        model = penalty_model(question.instance, question.row.encoding)
        form = Form.from_bqm(model.bqm)
        try:
            qaoa = DiagonalQAOA(form)
        except BackendError as error:  # refused before anything is allocated
            raise CannotRun(str(error)) from None
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


def _swap(line: Outcome, question: Question, reads: int, seed: int) -> Outcome:
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
    line.states = plans.size
    return _read_plans(line, question, qaoa, found, plans.costs, reads, seed, clock)


def _grover(line: Outcome, question: Question, reads: int, seed: int) -> Outcome:
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
    line.states = counted.size
    return _read_plans(line, question, qaoa, found, counted.levels, reads, seed, clock)


def _read_plans(
    line: Outcome,
    question: Question,
    qaoa: SubspaceQAOA,
    found: Tuning,
    distances: Floats,
    reads: int,
    seed: int,
    clock: Clock,
) -> Outcome:
    """Read a state of plans alone; `distances` are those of its amplitudes."""
    with clock.timed("run"):
        p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
        drawn = np.random.default_rng(seed).choice(len(p), reads, p=p / p.sum())
    line.probability = float(p[same(distances, question.optimum)].sum())
    line.details = {**_angles(found, qaoa.spread), "layers": len(found.gammas)}
    return judged(line, question, distances[drawn], clock, seed=seed, plans_only=True)


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


METHODS = {
    one.name: one
    for one in (
        *(
            Method(name, name, label, _anneal, partial(_warm_sampler, name))
            for name, label in zip(
                ANNEALERS, ("simulated annealing", "tabu search", "steepest descent"), strict=True
            )
        ),
        *(
            Method(name, name, f"VQE, {sdk}", _variational, partial(_warm_sampler, name))
            for name, sdk in zip(VQES, ("Qiskit", "PennyLane", "Braket"), strict=True)
        ),
        Method("penalty", "gates", "QAOA, penalty form, p = 1", _penalty, _warm_simulator),
        Method("swap", "gates", "QAOA, swap mixer, p = 4", _swap, _warm_simulator),
        Method("grover", "gates", "QAOA, Grover mixer, p = 10", _grover, _warm_simulator),
    )
}


def methods_for(
    row: PaperRow, *, large: bool = False, quick: bool = False
) -> list[tuple[Method, str | None]]:
    """Return the methods of a row, each with the reason why it is left out, or None.

    The penalty form and VQE simulate all 2^qubits states; beyond their sizes the mixers that
    keep the constraints take over, which know the n! plans only: enumerated up to n = 9, then
    counted.
    """
    found: list[tuple[Method, str | None]] = [(METHODS[name], None) for name in ANNEALERS]
    if row.items <= 3:
        why = None
        if quick:
            why = "left out by --quick"
        elif row.qubits > VQE_QUBITS:
            why = f"VQE is run up to {VQE_QUBITS} qubits, these are {row.qubits}"
        found += [(METHODS[name], why) for name in VQES]
    if row.qubits <= LARGE_QUBITS:
        why = None
        if row.qubits > QUBITS and not large:
            why = f"{row.qubits} qubits are simulated with --large only"
        found.append((METHODS["penalty"], why))
    if row.qubits > QUBITS:
        found.append((METHODS["swap" if row.items <= ENUMERATED else "grover"], None))
    return found
