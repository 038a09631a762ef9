"""Braket tasks and Runtime jobs, offline: Stubber and AwsSession subclass, fake backends."""

from __future__ import annotations

import datetime
import importlib.util
import json
import warnings
from types import SimpleNamespace

import dimod
import pytest

from qrobot.backends.braket.jobs import BraketTasks
from qrobot.backends.jobs import fetch, service_of
from qrobot.backends.qiskit.jobs import RuntimeJobs
from qrobot.errors import CredentialsError, RemoteError
from qrobot.jobs import (
    JobOptions,
    JobStore,
    RemoteService,
    by_shots,
    device_price,
    fetch_job,
    run_job,
)

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::SyntaxWarning"),
]

BQM = dimod.BQM({"a": 1.0, "b": -1.0, "c": 0.5}, {("a", "b"): 0.5}, 0.25, "BINARY")
SV1 = "arn:aws:braket:::device/quantum-simulator/amazon/sv1"
TASK = "arn:aws:braket:us-east-1:123456789012:quantum-task/11111111-2222-3333-4444-555555555555"
SECRET = "pl4ntedAwsSecretKeyValue0123456789abcdef"


def has(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


needs_braket = pytest.mark.skipif(not has("braket.aws"), reason="the extra braket is not installed")
needs_ibm = pytest.mark.skipif(
    not has("qiskit_ibm_runtime"), reason="the extra ibm is not installed"
)


def capabilities() -> str:
    return json.dumps(
        {
            "braketSchemaHeader": {
                "name": "braket.device_schema.simulators.gate_model_simulator_device_capabilities",
                "version": "1",
            },
            "service": {
                "braketSchemaHeader": {
                    "name": "braket.device_schema.device_service_properties",
                    "version": "1",
                },
                "executionWindows": [
                    {
                        "executionDay": "Everyday",
                        "windowStartHour": "00:00:00",
                        "windowEndHour": "23:59:59",
                    }
                ],
                "shotsRange": [0, 100000],
                "deviceCost": {"price": 0.075, "unit": "minute"},
            },
            "action": {
                "braket.ir.openqasm.program": {
                    "actionType": "braket.ir.openqasm.program",
                    "version": ["1"],
                    "supportedOperations": ["x", "h"],
                    "supportedResultTypes": [],
                }
            },
            "paradigm": {
                "braketSchemaHeader": {
                    "name": "braket.device_schema.simulators"
                    ".gate_model_simulator_paradigm_properties",
                    "version": "1",
                },
                "qubitCount": 34,
            },
            "deviceParameters": {},
        }
    )


def session_with(states: list[str], *, refuse: bool = False, stored: str = ""):
    """Return an AwsSession whose Braket client is stubbed and whose bucket is a text."""
    import boto3
    from botocore.stub import Stubber
    from braket.aws import AwsSession

    boto = boto3.Session(
        aws_access_key_id="AKIAPL4NTED012345678", aws_secret_access_key=SECRET,
        region_name="us-east-1",
    )  # fmt: skip
    client = boto.client("braket")

    class Session(AwsSession):
        def retrieve_s3_object_body(self, s3_bucket: str, s3_object_key: str) -> str:
            assert s3_object_key == f"tasks/{TASK.rsplit('/', maxsplit=1)[-1]}/results.json"
            return stored

    session = Session(boto_session=boto, braket_client=client, default_bucket="amazon-braket-x")
    stub = Stubber(client)
    if refuse:
        stub.add_client_error(
            "get_device", "UnrecognizedClientException", f"The token {SECRET} is invalid", 403
        )
        stub.activate()
        return session
    if states and states[0] == "device":
        stub.add_response(
            "get_device",
            {
                "deviceArn": SV1, "deviceCapabilities": capabilities(), "deviceName": "SV1",
                "deviceStatus": "ONLINE", "deviceType": "SIMULATOR",
                "providerName": "Amazon Braket",
            },
        )  # fmt: skip
        stub.add_response("create_quantum_task", {"quantumTaskArn": TASK})
        states = states[1:]
    begun = datetime.datetime(2026, 11, 1, 12, 0, 0, tzinfo=datetime.UTC)
    for state in states:
        answer = {
            "createdAt": begun, "deviceArn": SV1, "deviceParameters": "{}",
            "outputS3Bucket": "amazon-braket-x",
            "outputS3Directory": f"tasks/{TASK.rsplit('/', maxsplit=1)[-1]}",
            "quantumTaskArn": TASK, "shots": 20, "status": state,
            "actionMetadata": {"actionType": "braket.ir.openqasm.program", "executableCount": 1,
                               "programCount": 1},
        }  # fmt: skip
        if state == "COMPLETED":
            answer["endedAt"] = begun + datetime.timedelta(seconds=4)
        if state == "FAILED":
            answer["failureReason"] = "the laser is out"
        stub.add_response("get_quantum_task", answer)
    stub.activate()
    return session


def circuit():
    from braket.circuits import Circuit

    return Circuit().i(0).x(1).i(2)  # the ground state: b alone


def result_text() -> str:
    from braket.circuits.serialization import IRType
    from braket.default_simulator import StateVectorSimulator

    program = circuit().measure([0, 1, 2]).to_ir(ir_type=IRType.OPENQASM)
    return str(StateVectorSimulator().run(program, shots=20).json())


@needs_braket
def test_a_braket_task_from_device_to_samples_in_two_processes() -> None:
    from braket.aws import AwsDevice

    session = session_with(["device", "QUEUED", "RUNNING"])
    device = AwsDevice(SV1, aws_session=session)
    assert device_price(device.properties) == (0.075, "minute")

    def start(label: str):
        return device.run(circuit(), shots=20, tags={"qrobot": label})

    first = BraketTasks("braket-qaoa", start, device=device.name, cost=by_shots(20, 0, 0))
    assert isinstance(first, RemoteService)
    samples = run_job(first, BQM, JobOptions(wait=False))
    name = samples.info["remote"]["id"]
    with JobStore() as store:
        job = store.get(name)
        assert (job.remote_id, job.device, job.state) == (TASK, "SV1", "queued")
        assert isinstance(service_of(job, lambda _: None), BraketTasks)
        assert first.poll(job)[0] == "queued"
        assert first.poll(job)[0] == "running"
        later = BraketTasks(
            "braket-qaoa", sdk=session_with(["COMPLETED"] * 6, stored=result_text())
        )
        samples = fetch_job(later, job, store)
        assert len(samples) == 20
        assert samples.first.sample == {"a": 0, "b": 1, "c": 0}
        assert samples.first.energy == -0.75
        timing = samples.info["remote"]["timing"]
        assert timing["queue"] + timing["run"] == pytest.approx(4.0, abs=0.01)
        assert fetch(name, store, lambda _: None) == samples
        raw = b"".join(file.read_bytes() for file in store.path.parent.glob("jobs*"))
    assert SECRET.encode() not in raw


@needs_braket
def test_a_braket_task_that_fails_and_a_refused_key() -> None:
    from braket.aws import AwsDevice

    device = AwsDevice(SV1, aws_session=session_with(["device", "FAILED"]))
    jobs = BraketTasks("braket-qaoa", lambda _: device.run(circuit(), shots=20))
    with pytest.raises(RemoteError, match="failed: the laser is out"):
        run_job(jobs, BQM)
    bad = BraketTasks(
        "braket-qaoa", lambda _: AwsDevice(SV1, aws_session=session_with([], refuse=True))
    )
    with pytest.raises(CredentialsError, match="refused the credentials") as caught:
        run_job(bad, BQM)
    assert SECRET not in str(caught.value)
    assert caught.value.__context__ is None


@needs_ibm
def test_a_runtime_job_on_a_fake_backend() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from qiskit import QuantumCircuit, generate_preset_pass_manager
        from qiskit_ibm_runtime import SamplerV2
        from qiskit_ibm_runtime.fake_provider import FakeManilaV2

    backend = FakeManilaV2()
    made = QuantumCircuit(3)
    made.x(1)
    made.measure_all()
    made = generate_preset_pass_manager(optimization_level=1, backend=backend).run(made)
    started = {}

    def start(label: str):
        job = SamplerV2(mode=backend).run([made], shots=200)
        started[label] = job
        return job

    jobs = RuntimeJobs("qiskit-qaoa", start, device="fake_manila")
    samples = run_job(jobs, BQM, JobOptions(timeout=60))
    assert len(samples) == 200
    common = samples.aggregate().record
    best = common.sample[common.num_occurrences.argmax()]
    assert dict(zip(samples.variables, best.tolist(), strict=True)) == {"a": 0, "b": 1, "c": 0}
    # Another process, through the service: by id, and by tag where the id was not heard.
    ((label, job),) = started.items()
    service = SimpleNamespace(
        job=lambda name: job, jobs=lambda job_tags, limit: [job] if job_tags == [label] else []
    )
    with JobStore() as store:
        kept = store.get(label)
        later = RuntimeJobs("qiskit-qaoa", sdk=service)
        assert later.find(kept) == kept.remote_id
        assert later.poll(kept) == ("done", "")
        assert len(later.fetch(kept).samples) == 200
