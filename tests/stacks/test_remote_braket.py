"""The life of tasks on Amazon Braket, through the samplers: the real SDK, offline."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import dimod
import numpy as np
import pytest
from click.testing import CliRunner
from stacks.patterns import PATTERN, TURNED, pattern_model
from stacks.stacks import needs, small_model

from qrobot.backends import get
from qrobot.backends.braket.jobs import BraketTasks
from qrobot.errors import BackendError, RemoteError
from qrobot.jobs import JobStore, fetch_job, refresh, timing_fields

pytestmark = [
    needs("braket"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::SyntaxWarning"),
]

try:
    from stacks.cloud import DONE, GARNET, SV1, FolderSession, Session, on
except ImportError:
    DONE, GARNET, SV1 = (), "", ""


@pytest.mark.parametrize("vartype", ["BINARY", "SPIN"])
def test_from_the_model_to_counts_through_the_sdk(vartype):
    session = Session("device", "create", "QUEUED", *DONE)
    bqm = pattern_model(vartype)
    found = get("braket-vqe").sample(bqm, **on(session, num_reads=40, seed=1, **TURNED))
    session.stub.assert_no_pending_responses()
    assert len(found) == 40
    assert found.vartype is bqm.vartype
    assert (found.record.energy == -3.0).all()
    assert {v: int(x > 0) for v, x in found.first.sample.items()} == PATTERN
    (sent,) = session.sent
    assert sent["shots"] == 40
    assert sent["tags"] == {"qrobot": found.info["remote"]["job"]}
    with JobStore() as store:
        (job,) = store.list()
        assert (job.id, job.state) == (found.info["remote"]["job"], "done")
        assert store.answer(job) == found


def test_trained_here_read_there():
    session = Session("device", "create", *DONE)
    found = get("braket-qaoa").sample(small_model(), **on(session, num_reads=200, seed=1))
    session.stub.assert_no_pending_responses()
    info = found.info
    assert info["trained"] == "local"
    assert info["executions"] == info["evaluations"] + 1
    assert len(session.sent) == 1  # nothing but the reads is billed
    assert float((np.abs(found.record.energy + 5.2) < 1e-9).mean()) > 2 / 8
    parts = timing_fields(info)
    assert set(parts) == {"submit", "latency", "queue", "run", "return_"}
    assert set(info["timing"]) == {"build", "optimise"}
    json.dumps(info)


@pytest.mark.parametrize(("arn", "zz"), [(0, True), (1, False)])
def test_chips_without_zz_get_two_cnots_and_a_turn(arn, zz):
    arn, region = ((SV1, "us-east-1"), (GARNET, "eu-north-1"))[arn]
    gates = ("zz", "h") if zz else ("cz", "prx")
    about = {"gates": gates, "cost": (0.001, "shot")}
    session = Session(("device", about), "create", *DONE, arn=arn, region=region)
    found = get("braket-qaoa").sample(small_model(), **on(session, arn, num_reads=400, seed=1))
    action = session.sent[0]["action"]
    assert ("zz(" in action, "cnot " in action) == (zz, not zz)
    assert float((np.abs(found.record.energy + 5.2) < 1e-9).mean()) > 2 / 8


def test_training_on_the_device_is_estimated_as_a_whole():
    options = {"train": "device", "shots": 10, "evaluations": 3, "starts": 2, "optimizer": "spsa"}
    about = {"cost": (0.01, "shot")}
    session = Session(("device", about), arn=GARNET, region="eu-north-1")
    given = on(session, GARNET, num_reads=40, seed=1, **options)
    told = get("braket-vqe").estimate(small_model(), **given)
    assert told.usd == pytest.approx(7 * 0.30 + (6 * 10 + 40) * 0.01)
    assert "told by the device" in told.basis
    assert "assumed, not looked up" in told.basis
    session = Session(("device", about), arn=GARNET, region="eu-north-1")
    given = on(session, GARNET, num_reads=40, seed=1, **options)
    with pytest.raises(BackendError, match=r"3\.1 USD.*limit of 3 USD; nothing was submitted"):
        get("braket-vqe").sample(small_model(), **given, max_cost=3.0)
    assert session.sent == []
    with JobStore() as store:
        assert store.list() == []
    steps = ("create", *DONE) * 7
    session = Session(("device", about), *steps, arn=GARNET, region="eu-north-1")
    given = on(session, GARNET, num_reads=40, seed=1, **options)
    found = get("braket-vqe").sample(small_model(), **given, max_cost=4.0)
    session.stub.assert_no_pending_responses()
    assert [one["shots"] for one in session.sent] == [10] * 6 + [40]
    assert found.info["trained"] == "device"
    assert found.info["search"]["jobs"] == 6
    assert found.info["search"]["estimate"]["usd"] == pytest.approx(told.usd)
    with JobStore() as store:
        jobs = store.list()
    assert len(jobs) == 7
    assert all(job.state == "done" for job in jobs)


def test_a_search_on_the_device_sees_variables_in_their_sequence():
    session = Session("device", *("create", *DONE) * 2)
    given = TURNED | {"evaluations": 1, "optimizer": "none", "train": "device", "alpha": 1.0}
    found = get("braket-vqe").sample(pattern_model(), **on(session, shots=5, num_reads=5, **given))
    assert found.info["history"] == [pytest.approx(-3.0)]
    assert (found.record.energy == -3.0).all()


def test_slopes_on_the_device_are_counted():
    options = {"train": "device", "shots": 10, "evaluations": 3, "starts": 1, "optimizer": "adam"}
    session = Session(("device", {"cost": (0.0, "shot")}))
    told = get("braket-vqe").estimate(small_model(), **on(session, **options))
    assert told.usd == pytest.approx((3 * (2 * 6 + 1) + 1) * 0.30)  # six rotations, both ways


def test_a_dry_run_and_a_budget_submit_nothing():
    session = Session("device")
    found = get("braket-vqe").sample(small_model(), **on(session), dry_run=True)
    session.stub.assert_no_pending_responses()
    assert len(found) == 0
    estimate = found.info["remote"]["estimate"]
    assert estimate["usd"] == pytest.approx(3 * 0.075 / 60)  # the least that a simulator bills
    assert "assumption" in estimate["basis"]
    with pytest.raises(BackendError, match="nothing was submitted"):
        get("braket-vqe").sample(small_model(), **on(Session("device")), max_cost=0.001)
    about = {"cost": (1.0, "hour")}
    with pytest.raises(BackendError, match="cannot be estimated"):
        get("braket-vqe").sample(small_model(), **on(Session(("device", about))), max_cost=9.0)


def test_a_price_that_no_device_tells_is_assumed(monkeypatch):
    monkeypatch.setenv("QROBOT_USD_PER_BRAKET_SHOT", "0.5")
    session = Session(("device", {"cost": None}), arn=GARNET, region="eu-north-1")
    told = get("braket-qaoa").estimate(small_model(), **on(session, GARNET, num_reads=10))
    assert told.usd == pytest.approx(0.30 + 5.0)
    assert "QROBOT_USD_PER_BRAKET_SHOT says" in told.basis


def test_without_waiting_and_fetched_later():
    session = Session("device", "create")
    context = {"why": "test"}
    given = on(session, wait=False, context=context, num_reads=20, seed=1, **TURNED)
    found = get("braket-vqe").sample(pattern_model(), **given)
    session.stub.assert_no_pending_responses()
    assert len(found) == 0
    assert found.info["parameters"] == TURNED["initial_parameters"]
    name = found.info["remote"]["id"]
    later = Session("create", *DONE)
    later.create_quantum_task(
        deviceArn=SV1, shots=20, outputS3Bucket="x-bucket", outputS3KeyPrefix="x",
        action=session.sent[0]["action"], clientToken="x",
    )  # fmt: skip
    with JobStore() as store:
        job = store.get(name)
        assert job.context["why"] == "test"
        assert (job.context["service"], job.context["device"]) == ("braket", SV1)
        samples = fetch_job(BraketTasks(job.backend, sdk=later), job, store)
    assert (samples.record.energy == -3.0).all()
    assert samples.info["parameters"] == TURNED["initial_parameters"]
    assert samples.info["remote"]["timing"]["queue"] == pytest.approx(4.0, abs=0.5)


def test_a_late_answer_leaves_the_job():
    session = Session("device", "create", *("QUEUED",) * 60)
    with pytest.raises(RemoteError, match=r"longer than 0.3 s; the job goes on \(queued\)"):
        get("braket-vqe").sample(pattern_model(), **on(session, timeout=0.3, **TURNED))
    with JobStore() as store:
        assert store.list()[0].state == "queued"


def test_an_interrupted_search_submits_nothing():
    session = Session("device")
    with pytest.raises(RemoteError, match="interrupted before the reads"):
        get("braket-vqe").sample(small_model(), **on(session, interrupt_function=lambda: True))
    assert session.sent == []


KILLED = """
import sys, time, warnings
warnings.simplefilter("ignore")
from stacks.cloud import SV1, FolderSession
from stacks.patterns import TURNED, pattern_model
from qrobot.backends import get
session = FolderSession(sys.argv[1])
session.state = "QUEUED"
def stop():
    print("ready", flush=True)
    time.sleep(600)
setattr(session, sys.argv[2], stop)
get("braket-vqe").sample(
    pattern_model(), device=SV1, device_options={"aws_session": session}, num_reads=20, **TURNED)
"""


@pytest.mark.parametrize("when", ["after_create", "before_get"])
def test_a_killed_process_leaves_a_task_that_another_one_fetches(when, tmp_path, monkeypatch):
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
    session = FolderSession(folder)
    # Another process knows the id and the region alone, and makes its own session.
    asked = []
    monkeypatch.setattr(
        "qrobot.backends.braket.jobs.session", lambda region: asked.append(region) or session
    )
    monkeypatch.setenv("XDG_STATE_HOME", str(state))
    with JobStore() as store:
        (job,) = store.list()
        assert job.state == ("submitting" if when == "after_create" else "queued")
        name = job.id
    from qrobot.cli import jobs

    done = CliRunner().invoke(jobs.command, ["list", "--refresh"], catch_exceptions=False)
    assert "done" in done.output
    out = tmp_path / "samples.json"
    done = CliRunner().invoke(
        jobs.command, ["fetch", name, "--output", str(out)], catch_exceptions=False
    )
    assert "5 variables, 20 reads, energy least -3" in done.output
    samples = dimod.SampleSet.from_serializable(json.loads(out.read_text()))
    assert samples.first.sample == PATTERN
    assert set(asked) == {"us-east-1"}


def test_cancelling_by_id(tmp_path, monkeypatch):
    from qrobot.cli import jobs

    session = FolderSession(tmp_path / "service")
    session.state = "QUEUED"
    given = on(session, wait=False, **TURNED)
    name = get("braket-vqe").sample(pattern_model(), **given).info["remote"]["id"]
    monkeypatch.setattr("qrobot.backends.braket.jobs.session", lambda region: session)
    done = CliRunner().invoke(jobs.command, ["cancel", name], catch_exceptions=False)
    assert done.output == f"{name} is cancelled\n"
    assert len(session.cancelled) == 1


def test_a_task_of_nobody_is_not_found(tmp_path):
    session = FolderSession(tmp_path / "service")
    get("braket-vqe").sample(pattern_model(), **on(session, wait=False, **TURNED))
    with JobStore() as store:
        job = store.list()[0]
        job.remote_id, job.id = "", "qr-of-somebody-else"
        assert BraketTasks("braket-vqe", sdk=session).find(job) is None
        refresh(BraketTasks("braket-vqe", sdk=session), job, store)
        assert job.remote_id == ""
