"""The life of a job, with a service in a file: no SDK and no network."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import dimod
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jobs.fake_service import FileService

from qrobot.backends.jobs import cancel, fetch, refresh_all  # fmt: skip
from qrobot.errors import BackendError, InputError, RemoteError
from qrobot.jobs import (
    Backoff,
    JobOptions,
    JobStore,
    RemoteService,
    refresh,
    run_job,
    timing_fields,
)

BQM = dimod.BQM({"a": 1.0, "b": -1.0}, {("a", "b"): 0.5}, 0.25, "BINARY")
FAST = Backoff(first=0.001)


@pytest.fixture
def store(tmp_path: Path):
    with JobStore(tmp_path / "jobs.sqlite3") as store:
        yield store


@pytest.fixture
def service(tmp_path: Path) -> FileService:
    return FileService(tmp_path / "service")


def test_a_job_from_submission_to_samples(service: FileService, store: JobStore) -> None:
    assert isinstance(service, RemoteService)
    samples = run_job(service, BQM, JobOptions(context={"why": "test"}), store=store, num_reads=3)
    assert samples.first.sample == {"a": 0, "b": 1}
    assert samples.first.energy == -0.75
    remote = samples.info["remote"]
    (job,) = store.list()
    assert (job.id, job.state, job.device) == (remote["job"], "done", "shelf")
    assert job.context == {"why": "test", "extra": {"num_reads": 3}}
    assert job.bqm() == BQM
    assert remote["timing"] == job.timings
    assert store.answer(job) == samples
    assert set(timing_fields(samples.info)) == {"submit", "latency", "queue", "run", "return_"}
    assert timing_fields({}) == {}


def test_the_parts_add_up_to_the_total() -> None:
    from qrobot.jobs import breakdown

    parts = breakdown(submit=0.5, total=10, fetch=0.5, run=1, received=1e9, solved=1e9 + 6)
    assert parts == {"submit": 0.5, "latency": 3.0, "queue": 5.0, "run": 1.0, "return": 0.5}
    for known in ({}, {"run": 99.0}, {"run": 1.0, "received": 5.0, "solved": 4.0}):
        parts = breakdown(submit=0.5, total=10, fetch=0.5, **known)
        assert sum(parts.values()) == pytest.approx(10)
        assert min(parts.values()) >= 0


@given(*[st.floats(0, 1e6)] * 3, st.none() | st.floats(-1, 1e7), st.none() | st.floats(-9, 1e7))
def test_parts_are_never_negative_and_add_up(submit, rest, fetch, run, had) -> None:
    from qrobot.jobs import breakdown

    known = {} if had is None else {"received": 1e9, "solved": 1e9 + had}
    total = submit + rest + fetch
    parts = breakdown(submit=submit, total=total, fetch=fetch, run=run, **known)
    assert min(parts.values()) >= 0
    assert sum(parts.values()) == pytest.approx(total, rel=1e-9, abs=1e-6)


def test_a_dry_run_and_a_budget_submit_nothing(service: FileService, store: JobStore) -> None:
    samples = run_job(service, BQM, JobOptions(dry_run=True), store=store)
    assert len(samples) == 0
    assert samples.info["remote"]["estimate"]["usd"] == 0.5
    for usd, limit in ((0.5, 0.1), (None, 100.0)):
        service.usd = usd
        with pytest.raises(BackendError, match="nothing was submitted"):
            run_job(service, BQM, JobOptions(max_cost=limit), store=store)
    assert "submit" not in service.calls
    assert store.list() == []


def test_an_empty_model_asks_nobody(service: FileService, store: JobStore) -> None:
    assert run_job(service, dimod.BQM("SPIN"), store=store).first.energy == 0
    assert service.calls == []


def test_not_waiting_and_fetching_later(service: FileService, store: JobStore) -> None:
    service.hold = True
    samples = run_job(service, BQM, JobOptions(wait=False), store=store)
    name = samples.info["remote"]["id"]
    with pytest.raises(RemoteError, match="is queued; there is nothing to fetch"):
        fetch(name, store, lambda _: service)
    service.state(f"remote-{name}", "done")
    assert refresh_all(store.list(), store, lambda _: service) == []
    assert fetch(name, store, lambda _: service).first.energy == -0.75
    calls = len(service.calls)
    assert fetch(name, store, lambda _: service).first.energy == -0.75  # from the store
    assert len(service.calls) == calls
    with pytest.raises(InputError, match="is done already"):
        cancel(name, store, lambda _: service)


def test_a_late_or_interrupted_wait_leaves_the_job(service: FileService, store: JobStore) -> None:
    service.hold = True
    with pytest.raises(RemoteError, match=r"longer than 0.2 s; the job goes on \(queued\)"):
        run_job(service, BQM, JobOptions(timeout=0.2), store=store)
    with pytest.raises(RemoteError, match="was interrupted"):
        run_job(service, BQM, JobOptions(interrupt_function=lambda: True), store=store)
    (newer, older) = store.list()
    assert newer.state == older.state == "queued"
    assert cancel(newer.id, store, lambda _: service).state == "cancelled"
    assert service.state(newer.remote_id) == "cancelled"
    with pytest.raises(InputError, match=r"timeout: 0.0 is not a finite number above 0"):
        run_job(service, BQM, JobOptions(timeout=0.0), store=store)


def test_a_failed_job_says_why(service: FileService, store: JobStore) -> None:
    service.hold = True
    service.poll = lambda job: ("failed", "the fridge is warm")
    with pytest.raises(RemoteError, match="failed: the fridge is warm"):
        run_job(service, BQM, store=store)
    assert store.list()[0].problem == "the fridge is warm"


def test_polls_survive_trouble(service: FileService, store: JobStore) -> None:
    service.errors = {"poll": [TimeoutError()], "fetch": [ConnectionResetError()]}
    assert len(run_job(service, BQM, JobOptions(backoff=FAST), store=store)) == 3


def test_a_lost_answer_to_a_submission_is_found_by_its_label(
    service: FileService, store: JobStore
) -> None:
    service.errors = {"submitted": [TimeoutError()]}
    with pytest.raises(RemoteError, match="did not answer in time"):
        run_job(service, BQM, JobOptions(backoff=FAST), store=store)
    assert service.calls.count("submit") == 1  # never twice
    (job,) = store.list()
    assert (job.state, job.remote_id) == ("submitting", "")
    refresh(service, job, store)
    assert (job.state, job.problem) == ("done", "")
    assert len(fetch(job.id, store, lambda _: service)) == 3


def test_a_job_that_never_arrived(service: FileService, store: JobStore) -> None:
    service.errors = {"submit": [TimeoutError()]}
    with pytest.raises(RemoteError):
        run_job(service, BQM, store=store)
    job = cancel(store.list()[0].id, store, lambda _: service)
    assert job.state == "cancelled"
    assert "never confirmed it" in job.problem
    service.errors = {"submit": [ValueError("odd")]}
    with pytest.raises(RemoteError, match=r"failed \(ValueError: odd\)"):
        run_job(service, BQM, store=store)
    assert store.list()[0].state == "failed"


def test_a_backend_without_jobs(store: JobStore) -> None:
    from qrobot.jobs import RemoteJob

    job = store.add(RemoteJob("neal"))
    with pytest.raises(InputError, match="keeps no jobs"):
        fetch(job.id, store, lambda _: object())
    assert refresh_all([job], store, lambda _: object()) == [
        f"neal, job {job.id}: backend neal of job {job.id} keeps no jobs; see 'qrobot backends'"
    ]


KILLED = """
import sys, dimod
from jobs.fake_service import FileService
from qrobot.jobs import run_job
bqm = dimod.BQM({"a": 1.0, "b": -1.0}, {("a", "b"): 0.5}, 0.25, "BINARY")
service = FileService(sys.argv[1], hold=True)
if sys.argv[2] == "early":
    real = service.submit
    def submit(*args, **known):
        out = real(*args, **known)
        print("ready", flush=True)
        import time; time.sleep(60)
    service.submit = submit
else:
    real_poll = service.poll
    def poll(job):
        print("ready", flush=True)
        return real_poll(job)
    service.poll = poll
run_job(service, bqm)
"""


@pytest.mark.parametrize("when", ["early", "waiting"])
def test_jobs_survive_kill_9(when: str, tmp_path: Path) -> None:
    tests = Path(__file__).resolve().parents[1]
    paths = os.pathsep.join([str(tests), str(tests.parent)])
    state = tmp_path / "state"
    environment = dict(os.environ) | {"PYTHONPATH": paths, "XDG_STATE_HOME": str(state)}
    folder = tmp_path / "service"
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(folder), when],
        stdout=subprocess.PIPE, env=environment,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    service = FileService(folder)
    with JobStore(state / "qrobot" / "jobs.sqlite3") as store:
        (job,) = store.list()
        assert job.state == ("submitting" if when == "early" else "queued")
        refresh(service, job, store)
        assert job.state == "queued"
        service.state(job.remote_id, "done")
        samples = fetch(job.id, store, lambda _: service)
    assert samples.first.sample == {"a": 0, "b": 1}
    assert json.dumps(samples.info["remote"])
