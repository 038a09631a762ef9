"""What the three stacks share, without any of them."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stacks.stacks import random_model, small_model

from qrobot.backends.braket.devices import DEVICES, arn_of
from qrobot.backends.gate import Options, make_ansatz, terms
from qrobot.backends.gate.circuit import Circuit, Gate
from qrobot.backends.gate.engine import PlainEngine, StateEngine, room
from qrobot.backends.gate.form import Form, diagonal
from qrobot.backends.gate.objective import ExactObjective, ShotObjective, Tail
from qrobot.backends.gate.optimisers import GRADIENT, OPTIMISERS, Evaluations, minimise
from qrobot.backends.gate.sampler import VariationalSampler
from qrobot.backends.gate.state import general
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.errors import BackendError, InputError


class PlainSampler(VariationalSampler):
    """The shared sampler on numpy alone."""

    sdk, algorithm, extra = "plain", "vqe", "qiskit"

    def check(self, qubits, options):
        room(qubits, "numpy")
        return True

    def engine(self, circuit, options):
        return PlainEngine(circuit)


def every_gate() -> Circuit:
    gates = (
        Gate("h", (0,)), Gate("ry", (1,), 0, 0.7), Gate("rx", (2,), 1, -1.3), Gate("cz", (2, 0)),
        Gate("rzz", (0, 2), 2, 0.4), Gate("rzz", (1, 0), 0, 1.1), Gate("rz", (1,), 3),
        Gate("h", (2,)),
        Gate("rx", (0,), 2, 2.0), Gate("ry", (2,), 3),
    )  # fmt: skip
    return Circuit(3, gates, 4)


def test_gradients_agree_with_shifts_and_differences():
    circuit, rng = every_gate(), np.random.default_rng(3)
    point, weights = rng.normal(size=4), rng.normal(size=8)
    angles = circuit.angles(point)
    value, slope = PlainEngine(circuit).slope(angles, weights)
    other, shifted = StateEngine.slope(PlainEngine(circuit), angles, weights)
    assert value == pytest.approx(other, abs=1e-12)
    np.testing.assert_allclose(slope, shifted, atol=1e-12)
    for k in range(4):
        step = 1e-5 * np.eye(4)[k]
        ends = [
            PlainEngine(circuit).slope(circuit.angles(point + s), weights)[0] for s in (step, -step)
        ]
        assert circuit.pull_back(slope)[k] == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=1e-8)


@pytest.mark.parametrize("layers", [1, 2])
def test_qaoa_is_the_state_of_the_diagonal_simulator(layers):
    bqm = random_model(5, seed=layers)
    form = Form.from_bqm(bqm)
    ansatz = make_ansatz("qaoa", form, terms(bqm), layers)
    point = ansatz.start(np.random.default_rng(0))
    simulator = DiagonalQAOA(form)
    simulator.run(point[:layers] / form.spread, point[layers:])
    made = general.state(ansatz.circuit, ansatz.circuit.angles(point))
    assert abs(np.vdot(simulator.vector(), made)) == pytest.approx(1.0, abs=1e-12)


def test_the_problem_ansatz_begins_at_qaoa():
    bqm = random_model(4, seed=9)
    form = Form.from_bqm(bqm)
    states = [
        general.state(a.circuit, a.circuit.angles(a.centre))
        for a in (make_ansatz(name, form, terms(bqm), 2) for name in ("qaoa", "problem"))
    ]
    assert abs(np.vdot(*states)) == pytest.approx(1.0, abs=1e-12)


@given(st.integers(1, 6), st.integers(0, 10**6), st.sampled_from(["BINARY", "SPIN"]))
@settings(max_examples=40, deadline=None)
def test_ising_words_have_the_energies_of_the_model(qubits, seed, vartype):
    bqm = random_model(qubits, seed).change_vartype(vartype, inplace=False)
    z = 1.0 - 2.0 * ((np.arange(2**qubits)[:, None] >> np.arange(qubits)) & 1)
    words = sum(value * np.prod(z[:, list(at)], axis=1) for value, at in terms(bqm))
    np.testing.assert_allclose(words, diagonal(Form.from_bqm(bqm)), atol=1e-9)


@given(st.integers(0, 10**6), st.floats(0.01, 1.0))
@settings(max_examples=40, deadline=None)
def test_the_tail_is_the_mean_of_the_lowest_share(seed, alpha):
    rng = np.random.default_rng(seed)
    energies, p = rng.integers(0, 5, 16).astype(float), rng.dirichlet(np.ones(16))
    left, mean = alpha, 0.0
    for k in np.argsort(energies):
        taken = min(left, p[k])
        mean, left = mean + taken * energies[k], left - taken
    assert Tail(energies, alpha).value(p) == pytest.approx(mean / alpha, abs=1e-9)


def test_many_shots_come_near_the_exact_objective():
    bqm = small_model()
    form = Form.from_bqm(bqm)
    ansatz = make_ansatz("hardware", form, terms(bqm), 1)
    point = ansatz.start(np.random.default_rng(2))
    engine = PlainEngine(ansatz.circuit)
    exact = ExactObjective(engine, diagonal(form), 0.3)
    shots = ShotObjective(engine, form, 0.3, 40_000, np.random.default_rng(1))
    assert shots.value(point) == pytest.approx(exact.value(point), abs=0.05)
    np.testing.assert_allclose(shots.slope(point)[1], exact.slope(point)[1], atol=0.2)


@pytest.mark.parametrize("name", [name for name in OPTIMISERS if name not in ("none", "nft")])
def test_every_optimiser_lowers_a_bowl_within_its_budget(name):
    if name not in ("spsa", "adam"):
        pytest.importorskip("scipy", reason="scipy comes with each SDK")
    middle = np.array([0.5, -0.3])
    runs = Evaluations(
        lambda x: float(((x - middle) ** 2).sum()),
        np.zeros(2),
        slope=lambda x: (float(((x - middle) ** 2).sum()), 2 * (x - middle)),
        budget=60,
    )
    found = minimise(name, runs, np.random.default_rng(0))
    assert found.value < 0.05
    assert len(found.history) <= 60
    assert min(found.history) == found.value


def test_a_search_can_be_interrupted_and_refuses_nan():
    calls = []
    rng = np.random.default_rng(0)
    runs = Evaluations(
        lambda x: float(x @ x), np.ones(3), budget=1000,
        interrupted=lambda: calls.append(1) or len(calls) > 7,
    )  # fmt: skip
    assert len(minimise("spsa", runs, rng).history) == 7
    with pytest.raises(BackendError, match="finite"):
        minimise("spsa", Evaluations(lambda x: float("nan"), np.ones(1), budget=5), rng)


@pytest.mark.parametrize("alpha", [1.0, 0.2])
def test_nft_finds_the_best_of_a_full_turn(alpha):
    form = Form.from_bqm(random_model(3, seed=4))
    ansatz = make_ansatz("hardware", form, [], 1)
    objective = ExactObjective(PlainEngine(ansatz.circuit), diagonal(form), alpha)
    start = ansatz.start(np.random.default_rng(1))
    size = ansatz.circuit.size
    runs = Evaluations(objective.value, start, budget=2 * size + 1, turns=objective.turns)
    found = minimise("nft", runs, np.random.default_rng(0))
    assert len(found.history) == 2 * size + 1
    # What it says without a run is what a run says, and no turn of the last angle does better.
    assert objective.value(found.parameters) == pytest.approx(found.value, abs=1e-9)
    last = int(np.random.default_rng(0).permutation(size)[-1])
    turned = np.repeat(found.parameters[None], 400, axis=0)
    turned[:, last] += np.linspace(-np.pi, np.pi, 400)
    assert found.value <= min(objective.value(point) for point in turned) + 1e-3


def test_nft_reaches_the_ground_of_a_product_state():
    # Without entanglers one pass is enough for independent spins: each goes to its lowest.
    fields = dimod.BinaryQuadraticModel({k: (-1) ** k * (k + 1) for k in range(5)}, {}, "SPIN")
    found = PlainSampler().sample(fields, optimizer="nft", layers=0, alpha=1.0, starts=1, seed=0)
    assert found.info["ground_probability"] == pytest.approx(1.0, abs=1e-3)
    assert found.info["evaluations"] < 4 * 11  # settled before its budget


def test_nft_says_where_it_cannot_work():
    for wrong in ({"shots": 50}, {"ansatz": "problem"}):
        with pytest.raises(InputError, match="nft needs exact probabilities"):
            PlainSampler().sample(small_model(), optimizer="nft", **wrong)


def test_one_seed_gives_one_answer_and_its_parameters_resume_it():
    bqm = random_model(4, seed=1)
    one, two = (
        PlainSampler().sample(bqm, seed=5, num_reads=50, evaluations=12, alpha=1.0) for _ in "ab"
    )
    assert (one.record.sample == two.record.sample).all()
    assert one.info["parameters"] == two.info["parameters"]
    assert len(one.info["history"]) == one.info["evaluations"] == sum(one.info["searches"])
    assert one.info["objective"] == min(one.info["history"])
    more = PlainSampler().sample(
        bqm, seed=6, evaluations=5, alpha=1.0, initial_parameters=one.info["parameters"]
    )
    assert more.info["history"][0] == pytest.approx(one.info["objective"], abs=1e-9)
    assert more.info["searches"] == [5]


def test_gradients_are_used_where_they_are_cheap():
    assert PlainSampler().sample(small_model(), seed=0).info["optimizer"] in GRADIENT
    shots = PlainSampler().sample(small_model(), seed=0, shots=50, evaluations=4)
    assert shots.info["optimizer"] == "spsa"


def test_reads_follow_the_probabilities():
    found = PlainSampler().sample(small_model(), seed=0, num_reads=20_000, evaluations=0)
    share = float((np.abs(found.record.energy - found.info["ground_energy"]) < 1e-9).mean())
    assert share == pytest.approx(found.info["ground_probability"], abs=0.02)
    assert found.info["ground_probability_uniform"] == pytest.approx(1 / 8)
    assert found.info["objective"] is None


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("alpha", 0.0), ("alpha", 1.5), ("alpha", "x"), ("alpha", float("nan")), ("num_reads", 0),
        ("layers", -1), ("optimizer", "magic"), ("ansatz", "magic"), ("shots", 0), ("seed", -1),
        ("initial_parameters", [1.0]), ("initial_parameters", [np.nan] * 6), ("starts", 0),
        ("initial_parameters", "abc"), ("evaluations", 1.5), ("train", "moon"),
    ],
)  # fmt: skip
def test_bad_options_are_refused_by_name(field, value):
    with pytest.raises(InputError, match=field):
        PlainSampler().sample(small_model(), **{field: value})


def test_unknown_options_are_refused():
    with pytest.raises(InputError, match="speed"):
        PlainSampler().sample(small_model(), speed=3)
    assert Options().share(16) == 0.05
    assert Options().share(2) == 1.0


def test_a_state_that_cannot_fit_is_refused_with_its_size():
    bqm = dimod.BinaryQuadraticModel(dict.fromkeys(range(3000), 1.0), {}, 0.0, "BINARY")
    with pytest.raises(BackendError, match=r"3000 qubits .* needs .* bytes"):
        PlainSampler().sample(bqm)


@pytest.mark.parametrize("name", [*DEVICES, "rigetti", "ionq", "iqm", *DEVICES.values()])
def test_braket_names_and_arns_are_found(name):
    assert arn_of(name) in DEVICES.values()
    assert arn_of(name.lower()) or True


@pytest.mark.parametrize(
    ("name", "successor"),
    [
        ("TN1", "SV1"),
        ("arn:aws:braket:::device/quantum-simulator/amazon/tn1", "SV1"),
        ("arn:aws:braket:::device/qpu/rigetti/Aspen-9", "Cepheus"),
        ("Ankaa-3", "Cepheus"),
        ("arn:aws:braket:us-east-1::device/qpu/ionq/Harmony", "Forte"),
        ("arn:aws:braket:us-west-2::device/qpu/d-wave/Advantage_system6", "Leap"),
        ("arn:aws:braket:us-east-1::device/qpu/quera/Aquila", "SV1"),
    ],
)
def test_retired_devices_are_refused_with_their_successor(name, successor):
    with pytest.raises(BackendError, match=successor):
        arn_of(name)


@pytest.mark.parametrize("name", ["", "moon", "arn:aws:s3:::bucket", "arn:aws:braket:x"])
def test_what_is_no_device_is_refused(name):
    with pytest.raises(InputError, match="device"):
        arn_of(name)
