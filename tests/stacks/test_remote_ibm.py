"""The life of jobs on IBM hardware, through the samplers: fake machines in local testing mode."""

from __future__ import annotations

import importlib.util
from collections import Counter
from types import SimpleNamespace
from typing import ClassVar

import dimod
import numpy as np
import pytest
from stacks.patterns import PATTERN, pattern_model
from stacks.patterns import TURNED as GIVEN
from stacks.stacks import needs, small_model

from qrobot.backends import get
from qrobot.backends.qiskit.jobs import RuntimeJobs
from qrobot.errors import BackendError, CredentialsError, InputError, RemoteError
from qrobot.jobs import JobStore, fetch_job

pytestmark = [
    needs("qiskit"),
    pytest.mark.skipif(
        importlib.util.find_spec("qiskit_ibm_runtime") is None,
        reason="the extra ibm is not installed: pip install 'qrobot[ibm]'",
    ),
]

TURNED = GIVEN | {"seed": 1}


@pytest.fixture(scope="module")
def manila():
    from qiskit_ibm_runtime.fake_provider import FakeManilaV2

    return FakeManilaV2()


@pytest.fixture(scope="module")
def paid():
    """The same machine, as if a service ran its jobs and billed them."""
    from qiskit_ibm_runtime.fake_provider import FakeManilaV2

    class Paid(FakeManilaV2):
        service = SimpleNamespace()

    return Paid()


def modes(backend):
    from qiskit_ibm_runtime import Batch, Session

    return {
        "backend": backend,
        "session": Session(backend=backend),
        "batch": Batch(backend=backend),
    }


def most_common(found):
    reads = Counter(map(tuple, found.record.sample.tolist()))
    return dict(zip(found.variables, reads.most_common(1)[0][0], strict=True))


@pytest.mark.parametrize("kind", ["backend", "session", "batch"])
def test_modes_read_each_variable_in_its_place(kind, manila):
    mode = modes(manila)[kind]
    found = get("qiskit-vqe").sample(pattern_model(), mode=mode, num_reads=300, **TURNED)
    assert len(found) == 300
    assert most_common(found) == PATTERN  # the machine is noisy, and the circuit was routed
    info = found.info
    assert info["device"] == "fake_manila"
    assert info["remote"]["estimate"]["usd"] == 0.0
    assert set(info["remote"]["timing"]) == {"submit", "latency", "queue", "run", "return"}
    with JobStore() as store:
        (job,) = store.list()
        assert (job.id, job.state) == (info["remote"]["job"], "done")
        assert store.answer(job) == found


@pytest.mark.parametrize("vartype", ["BINARY", "SPIN"])
def test_entangled_and_routed_circuits_find_the_ground(vartype, manila):
    bqm = small_model().change_vartype(vartype, inplace=False)
    found = get("qiskit-qaoa").sample(bqm, mode=manila, seed=1, optimization_level=3)
    assert found.info["trained"] == "local"
    assert set(found.info["gates"]) <= {"rz", "sx", "x", "cx", "measure", "barrier"}
    assert found.aggregate().first.energy == pytest.approx(-5.2)
    assert float((np.abs(found.record.energy + 5.2) < 1e-9).mean()) > 2 / 8


def test_training_in_a_session_is_one_job_an_evaluation(manila):
    mode = modes(manila)["session"]
    found = get("qiskit-vqe").sample(
        small_model(), mode=mode, train="device", shots=50, evaluations=3, starts=1, seed=1,
        optimizer="spsa", num_reads=60,
    )  # fmt: skip
    assert found.info["trained"] == "device"
    assert found.info["search"]["jobs"] == 3
    assert len(found) == 60
    with JobStore() as store:
        assert len(store.list()) == 4


def test_what_a_machine_bills_is_estimated_by_its_durations(paid, monkeypatch):
    sampler = get("qiskit-vqe")
    told = sampler.estimate(pattern_model(), mode=paid, num_reads=1000, **TURNED)
    # Two seconds a job, and a thousand shots of 250 us and some gates and a readout of 5 us.
    assert 2.25 < told.seconds < 2.27
    assert told.usd == pytest.approx(told.seconds * 1.60)
    assert "assumed, not looked up" in told.basis
    options = {"train": "device", "shots": 100, "evaluations": 5, "starts": 2, "optimizer": "spsa"}
    more = sampler.estimate(small_model(), mode=paid, num_reads=1000, **options)
    assert more.seconds == pytest.approx(11 * 2.0 + 2000 * 255e-6, abs=0.02)
    session = modes(paid)["session"]
    assert "a session bills all the time" in sampler.estimate(small_model(), mode=session).basis
    monkeypatch.setenv("QROBOT_USD_PER_IBM_SECOND", "10")
    assert sampler.estimate(pattern_model(), mode=paid, **TURNED).usd > 20
    assert sampler.runs_remotely(mode=paid)
    assert not sampler.runs_remotely()


def test_a_machine_without_durations_is_assumed_slow(paid, monkeypatch):
    from qiskit import QuantumCircuit

    def unknown(*_args, **_options):
        raise ValueError("no durations")

    monkeypatch.setattr(QuantumCircuit, "estimate_duration", unknown)
    told = get("qiskit-vqe").estimate(pattern_model(), mode=paid, **TURNED)
    assert "assumed, 1e-06 s a layer" in told.basis


def test_a_dry_run_and_a_budget_submit_nothing(paid):
    sampler = get("qiskit-vqe")
    found = sampler.sample(pattern_model(), mode=paid, dry_run=True, **TURNED)
    assert len(found) == 0
    assert found.info["remote"]["estimate"]["usd"] > 3
    with pytest.raises(BackendError, match="limit of 3 USD; nothing was submitted"):
        sampler.sample(pattern_model(), mode=paid, max_cost=3.0, **TURNED)
    with JobStore() as store:
        assert store.list() == []


def test_jobs_are_tagged_and_fetched_by_id(paid, monkeypatch):
    from qiskit_ibm_runtime.executor_sampler import Sampler

    jobs, run = {}, Sampler.run

    def recorded(self, *args, **options):
        job = run(self, *args, **options)
        jobs[tuple(self.options.environment.job_tags)] = job
        return job

    monkeypatch.setattr(Sampler, "run", recorded)
    found = get("qiskit-vqe").sample(
        pattern_model(), mode=paid, wait=False, max_cost=10.0, context={"why": "test"}, **TURNED
    )
    assert len(found) == 0
    name = found.info["remote"]["id"]
    assert list(jobs) == [(name,)]
    service = SimpleNamespace(
        job=lambda remote_id: {job.job_id(): job for job in jobs.values()}[remote_id],
        jobs=lambda job_tags, limit: [jobs[tuple(job_tags)]],
    )
    with JobStore() as store:
        job = store.get(name)
        assert job.context["why"] == "test"
        later = RuntimeJobs(job.backend, sdk=service)
        assert later.find(job) == job.remote_id
        jobs[(name,)].result()
        samples = fetch_job(later, job, store)
    assert most_common(samples) == PATTERN
    assert samples.info["parameters"] == TURNED["initial_parameters"]


def test_too_many_qubits(manila):
    for qubits in (6, 20_000):
        bqm = dimod.BinaryQuadraticModel(dict.fromkeys(range(qubits), 1.0), {}, 0.0, "BINARY")
        with pytest.raises(BackendError, match=rf"{qubits} qubits.*fake_manila has 5"):
            get("qiskit-qaoa").sample(bqm, mode=manila)
    with pytest.raises(InputError, match="mode"):
        get("qiskit-vqe").sample(small_model(), mode="ibm")


class Account:
    """A service of the user's account; `machines` by name."""

    machines: ClassVar[dict[str, object]] = {}

    def backend(self, name):
        from qiskit.providers.exceptions import QiskitBackendNotFoundError

        if name not in self.machines:
            raise QiskitBackendNotFoundError("No backend matches the criteria.")
        return self.machines[name]

    def least_busy(self, min_num_qubits, **_):
        fits = [name for name, one in self.machines.items() if one.num_qubits >= min_num_qubits]
        return self.backend(fits[0] if fits else "")


@pytest.mark.parametrize("device", ["ibm", "ibm:moon"])
def test_a_machine_of_the_account_by_name_or_the_least_busy(device, paid, monkeypatch):
    import qiskit_ibm_runtime

    monkeypatch.setenv("QISKIT_IBM_TOKEN", "pl4nted-token-of-a-robot")
    monkeypatch.setattr(qiskit_ibm_runtime, "QiskitRuntimeService", Account)
    monkeypatch.setattr(Account, "machines", {"moon": paid})
    sampler = get("qiskit-vqe")
    assert sampler.estimate(pattern_model(), device=device, **TURNED).usd > 3
    found = sampler.sample(pattern_model(), device=device, num_reads=100, **TURNED)
    assert most_common(found) == PATTERN
    monkeypatch.setattr(Account, "machines", {})
    with pytest.raises(BackendError, match="no machine of this IBM Quantum account"):
        sampler.sample(pattern_model(), device=device, **TURNED)


def test_no_account_is_told_without_a_network():
    with pytest.raises(CredentialsError, match="there are no credentials for IBM Quantum"):
        get("qiskit-vqe").sample(small_model(), device="ibm:moon")


@pytest.mark.parametrize("error", [AttributeError, RuntimeError])
def test_an_account_that_is_refused_tells_no_token(error, monkeypatch):
    runtime = pytest.importorskip("qiskit_ibm_runtime")
    token = "pl4nted-token-of-a-robot"

    def refuse(*_args, **_options):
        raise error(f"no instance for token {token}")

    monkeypatch.setenv("QISKIT_IBM_TOKEN", token)
    monkeypatch.setattr(runtime, "QiskitRuntimeService", refuse)
    kind = CredentialsError if error is AttributeError else RemoteError
    with pytest.raises(kind, match="IBM Quantum") as caught:
        get("qiskit-vqe").sample(small_model(), device="ibm:moon", evaluations=0)
    assert token not in str(caught.value)
    assert caught.value.__context__ is None
