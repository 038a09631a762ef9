"""D-Wave: the mock QPU, and the real SDK against a solver API on the loopback."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import dimod
import dimod.testing
import numpy as np
import pytest
from processes import until

from qrobot.backends.jobs import cancel, fetch
from qrobot.errors import BackendError, CredentialsError, InputError, MissingExtraError, RemoteError
from qrobot.jobs import JobStore, refresh

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # what others' modules say while they are compiled
    try:
        import dwave.cloud.api
        import dwave.system.testing
    except ImportError:
        dwave = None

needs_dwave = pytest.mark.skipif(dwave is None, reason="the extra dwave is not installed")
pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning:dwave"),
    # dwave-cloud-client leaves the temporary file of a nonlinear model to the collector.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning"),
]

TOKEN = "DEV-pl4ntedpl4ntedpl4nted0123456789"


def random_bqm(n: int = 9, vartype: str = "BINARY") -> dimod.BQM:
    bqm = dimod.generators.gnm_random_bqm(n, 2 * n, vartype, random_state=1)
    bqm.offset = 2.5
    return bqm.relabel_variables({i: ("x", i, 0) for i in range(n)}, inplace=False)


def mocked(**known: object):
    from dwave.system.testing import MockDWaveSampler

    from qrobot.backends.dwave.qpu import DWaveQPUSampler

    mock = MockDWaveSampler(topology_type="pegasus", topology_shape=[3], **known)
    return DWaveQPUSampler(mock)


@needs_dwave
class TestMockQPU:
    @pytest.mark.parametrize("vartype", ["BINARY", "SPIN"])
    def test_samples_chains_and_energies(self, vartype: str) -> None:
        bqm = random_bqm(vartype=vartype)
        samples = mocked().sample(bqm, num_reads=30, seed=1, chain_strength=2.0)
        assert set(samples.variables) == set(bqm.variables)
        assert samples.vartype is bqm.vartype
        dimod.testing.assert_sampleset_energies(samples, bqm)
        about = samples.info["embedding"]
        assert about["chain_strength"] == 2.0
        assert 0 <= about["chain_break_fraction"] <= 1
        assert about["qubits"] >= 9
        assert "chain_break_fraction" in samples.record.dtype.names
        assert samples.info["remote"]["timing"]["run"] > 0

    def test_dimod_sampler_api(self) -> None:
        sampler = mocked()
        dimod.testing.assert_sampler_api(sampler)
        for source in (dimod.BQM({}, {"ab": 1}, 0, "SPIN"), dimod.BQM("BINARY")):
            dimod.testing.assert_sampleset_energies(sampler.sample(source), source)
        dimod.testing.assert_sampleset_energies(
            sampler.sample_qubo({(0, 1): -1}), dimod.BQM.from_qubo({(0, 1): -1})
        )
        dimod.testing.assert_sampleset_energies(
            sampler.sample_ising({0: 1}, {(0, 1): -1}), dimod.BQM.from_ising({0: 1}, {(0, 1): -1})
        )

    def test_weak_chains_break_and_it_is_reported(self) -> None:
        bqm = dimod.generators.gnm_random_bqm(10, 45, "SPIN", random_state=2)
        sampler = mocked(exact_solver_cutoff=0)
        weak = sampler.sample(bqm, num_reads=50, seed=1, chain_strength=1e-3)
        assert weak.info["embedding"]["longest_chain"] > 1
        assert weak.info["embedding"]["chain_break_fraction"] > 0
        strong = sampler.sample(bqm, num_reads=50, seed=1, chain_strength=20.0)
        assert strong.info["embedding"]["chain_break_fraction"] == 0

    def test_what_does_not_fit_is_refused(self) -> None:
        with pytest.raises(BackendError, match=r"the model has 500 variables, .* has 128 qubits"):
            mocked().sample(dimod.BQM(dict.fromkeys(range(500), 1.0), {}, 0, "SPIN"))
        dense = dimod.generators.gnm_random_bqm(60, 1770, "SPIN")
        with pytest.raises(BackendError, match="no embedding of 60 variables and 1770 couplings"):
            mocked().sample(dense, embedding_parameters={"timeout": 1, "tries": 1})

    def test_nonsense_is_refused(self) -> None:
        with pytest.raises(InputError, match="not a finite number"):
            mocked().sample(dimod.BQM({"a": float("inf")}, {}, 0, "SPIN"))
        with pytest.raises(InputError, match=r"chain_break_method: .* is not one of majority_vote"):
            mocked().sample(random_bqm(), chain_break_method="hammer")
        with pytest.raises(BackendError, match="publishes no timing model"):
            mocked().sample(random_bqm(), max_cost=1)


@pytest.fixture
def api(monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("dwave.system", reason="the extra dwave is not installed")
    from jobs.fake_sapi import serving

    with serving() as server:
        monkeypatch.setenv("DWAVE_API_ENDPOINT", server.url)
        monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
        yield server
        while MADE:
            MADE.pop().close()


MADE = []
"""Samplers to close: each connection of the SDK has some thirty threads."""


def kept(sampler):
    MADE.append(sampler)
    return sampler


def qpu():
    from qrobot.backends.dwave.qpu import DWaveQPUSampler

    return kept(DWaveQPUSampler())


def hybrid():
    from qrobot.backends.dwave.leap import LeapBQMSampler

    return kept(LeapBQMSampler())


def constrained():
    from qrobot.backends.dwave.leap import LeapCQMSampler

    return kept(LeapCQMSampler())


def nonlinear():
    from qrobot.backends.dwave.leap import LeapNLSampler

    return kept(LeapNLSampler())


@pytest.mark.parametrize("vartype", ["BINARY", "SPIN"])
@pytest.mark.parametrize("make", [qpu, hybrid, constrained, nonlinear])
def test_the_real_sdk_from_token_to_samples(api, make, vartype: str) -> None:
    bqm = random_bqm(vartype=vartype)
    samples = make().sample(bqm, timeout=30)
    dimod.testing.assert_sampleset_energies(samples, bqm)
    assert set(samples.variables) == set(bqm.variables)
    assert samples.vartype is bqm.vartype
    if make in (constrained, nonlinear):
        assert samples.first.energy == pytest.approx(dimod.ExactSolver().sample(bqm).first.energy)
    remote = samples.info["remote"]
    assert api.sapi.problems[remote["remote_id"]]["label"] == remote["job"]
    assert set(remote["timing"]) == {"submit", "latency", "queue", "run", "return"}
    assert remote["estimate"]["usd"] > 0
    assert set(api.sapi.tokens) == {TOKEN}
    assert TOKEN not in repr(samples.info)


@pytest.mark.parametrize("make", [qpu, hybrid])
def test_a_budget_is_kept_before_anything_bills(api, make) -> None:
    samples = make().sample(random_bqm(), dry_run=True)
    usd = samples.info["remote"]["estimate"]["usd"]
    assert usd > 0
    with pytest.raises(BackendError, match="nothing was submitted"):
        make().sample(random_bqm(), max_cost=usd / 2)
    assert api.sapi.posted == 0
    assert len(make().sample(random_bqm(), max_cost=usd * 2)) > 0


def test_more_reads_cost_more(api) -> None:
    sampler = qpu()
    few, many = (sampler.estimate(random_bqm(), num_reads=n, seed=1) for n in (1, 1000))
    assert few.usd is not None
    assert many.usd is not None
    assert many.usd > few.usd
    assert many.seconds == pytest.approx(few.seconds + 999e-6 * (20 + 21 + 10**1.5), rel=0.1)


@pytest.mark.parametrize("make", [qpu, hybrid])
def test_a_refused_token_is_one_sentence(api, make) -> None:
    api.sapi.refuse = True
    with pytest.raises(CredentialsError, match="refused the credentials") as caught:
        make().sample(random_bqm())
    assert TOKEN not in str(caught.value)
    assert caught.value.__context__ is None


def threads_fall_to(count: int) -> bool:
    until(lambda: threading.active_count() <= count, "the threads go on")
    return True


@needs_dwave
@pytest.mark.parametrize("make", [qpu, hybrid])
def test_no_token_is_told_at_once(make) -> None:
    with pytest.raises(CredentialsError, match="set DWAVE_API_TOKEN"):
        make().sample(random_bqm())


@needs_dwave
@pytest.mark.parametrize("make", [qpu, hybrid])
def test_a_dead_endpoint_is_told_in_time(make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DWAVE_API_ENDPOINT", "http://127.0.0.1:9/")
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
    before = threading.active_count()
    with pytest.raises(RemoteError, match="cannot be reached") as caught:
        make().sample(random_bqm(), timeout=1.0)
    assert TOKEN not in str(caught.value)
    # The SDK would leave a dozen threads at each try; those that were told to end need a moment.
    assert threads_fall_to(before)


def test_closing_ends_the_threads(api) -> None:
    before = threading.active_count()
    sampler = qpu()
    sampler.sample(random_bqm(), num_reads=2)
    assert threading.active_count() > before
    sampler.close()
    assert threads_fall_to(before + 1)  # one of the server's, perhaps
    assert len(sampler.sample(random_bqm(), num_reads=2)) > 0


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dwave.system", None)
    for make in (qpu, hybrid):
        sampler = make()
        assert "time_limit" in sampler.parameters or "chain_strength" in sampler.parameters
        with pytest.raises(MissingExtraError, match=r"pip install 'qrobot\[dwave\]'"):
            sampler.sample(random_bqm())


def test_a_job_fetched_by_another_sampler(api) -> None:
    bqm = random_bqm()
    for make in (qpu, hybrid, constrained, nonlinear):
        name = make().sample(bqm, wait=False).info["remote"]["id"]
        with JobStore() as store:
            other = make()
            job = store.get(name)
            while not job.ended:
                refresh(other, job, store)
            samples = fetch(name, store, lambda _, other=other: other)
        dimod.testing.assert_sampleset_energies(samples, bqm)
        assert np.isfinite(sum(samples.info["remote"]["timing"].values()))


def test_a_job_is_cancelled(api) -> None:
    api.sapi.hold = True
    name = qpu().sample(random_bqm(), wait=False).info["remote"]["id"]
    with JobStore() as store:
        job = cancel(name, store, lambda _: qpu())
        assert job.state == "cancelled"
        assert api.sapi.problems[job.remote_id]["status"] == "CANCELLED"


def test_a_job_whose_submission_was_not_confirmed(api) -> None:
    api.sapi.deaf = True
    with pytest.raises(RemoteError):
        qpu().sample(random_bqm(), timeout=10)
    assert api.sapi.posted == 1
    api.sapi.deaf = False
    with JobStore() as store:
        (job,) = store.list()
        assert job.state == "submitting"
        sampler = qpu()
        while not job.ended:
            refresh(sampler, job, store)
        samples = fetch(job.id, store, lambda _: sampler)
    dimod.testing.assert_sampleset_energies(samples, random_bqm())


def test_a_too_short_time_limit(api) -> None:
    with pytest.raises(InputError, match=r"below the solver's least of 3 s"):
        hybrid().sample(random_bqm(), time_limit=0.5)


KILLED = """
import dimod
from jobs.test_dwave import qpu, random_bqm
qpu().sample(random_bqm(), interrupt_function=lambda: print("waiting", flush=True))
"""


def test_a_qpu_job_survives_kill_9(api) -> None:
    api.sapi.hold = True
    tests = Path(__file__).resolve().parents[1]
    paths = os.pathsep.join([str(tests), str(tests.parent)])
    with subprocess.Popen(
        [sys.executable, "-c", KILLED], stdout=subprocess.PIPE,
        env=dict(os.environ) | {"PYTHONPATH": paths},
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stdout.readline() == b"waiting\n"
        assert TOKEN not in Path(f"/proc/{process.pid}/cmdline").read_text()
        process.send_signal(signal.SIGKILL)
    api.sapi.hold = False
    with JobStore() as store:
        (job,) = store.list()
        sampler = qpu()
        while not job.ended:
            refresh(sampler, job, store)
        samples = fetch(job.id, store, lambda _: sampler)
        raw = b"".join(file.read_bytes() for file in store.path.parent.glob("jobs*"))
    dimod.testing.assert_sampleset_energies(samples, random_bqm())
    assert TOKEN.encode() not in raw
