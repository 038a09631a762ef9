"""What goes wrong on Amazon Braket: refusals before anything is billed, and clear errors after."""

from __future__ import annotations

import dimod
import pytest
from stacks.patterns import TURNED, pattern_model
from stacks.stacks import needs, random_model, small_model

from qrobot.backends import get
from qrobot.errors import BackendError, CredentialsError, InputError, RemoteError
from qrobot.jobs import JobStore

pytestmark = [
    needs("braket"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::SyntaxWarning"),
]

try:
    from stacks.cloud import DONE, SECRET, SV1, Session, on
except ImportError:
    DONE, SECRET, SV1 = (), "", ""


def test_throttling_is_waited_out():
    busy = ("ThrottlingException", "Rate exceeded", 429)
    session = Session(
        ("error", "get_device", *busy), "device", ("error", "create_quantum_task", *busy),
        "create", ("error", "get_quantum_task", *busy), *DONE,
    )  # fmt: skip
    found = get("braket-vqe").sample(pattern_model(), **on(session, **TURNED))
    session.stub.assert_no_pending_responses()
    assert len(session.sent) == 2  # the refused one, and the one that arrived
    assert (found.record.energy == -3.0).all()


@pytest.mark.parametrize("code", ["AccessDeniedException", "ExpiredTokenException"])
@pytest.mark.parametrize("operation", ["get_device", "create_quantum_task", "get_quantum_task"])
def test_refused_credentials(code, operation):
    steps = ["get_device", "create_quantum_task", "get_quantum_task"]
    before = ["device", "create"][: steps.index(operation)]
    session = Session(*before, ("error", operation, code, f"key {SECRET} is refused", 403))
    with pytest.raises(CredentialsError, match="refused the credentials") as caught:
        get("braket-vqe").sample(pattern_model(), **on(session, **TURNED))
    session.stub.assert_no_pending_responses()  # never tried again
    assert SECRET not in str(caught.value)


@pytest.mark.parametrize("status", ["OFFLINE", "RETIRED"])
def test_a_device_that_is_away(status):
    session = Session(("device", {"status": status}))
    with pytest.raises(BackendError, match=f"is {status} and takes no tasks"):
        get("braket-vqe").sample(small_model(), **on(session))


def test_a_retired_device_is_refused_before_any_call():
    session = Session()
    with pytest.raises(BackendError, match="retired"):
        get("braket-vqe").sample(small_model(), **on(session, f"{SV1[:-3]}tn1"))
    assert session.sent == []


def test_what_is_too_large_for_the_device():
    session = Session(("device", {"qubits": 4}))
    with pytest.raises(BackendError, match=r"needs 5 qubits and device sv1 has 4"):
        get("braket-qaoa").sample(random_model(5, 1), **on(session))
    session = Session(("device", {"shots": 100}))
    with pytest.raises(InputError, match=r"num_reads.*at most 100 shots"):
        get("braket-qaoa").sample(small_model(), **on(session, num_reads=101))
    session = Session(("device", {"qubits": 34}))
    large = dimod.BinaryQuadraticModel(dict.fromkeys(range(20_000), 1.0), {}, 0.0, "BINARY")
    with pytest.raises(BackendError, match=r"needs 20000 qubits and device sv1 has 34"):
        get("braket-vqe").sample(large, **on(session, evaluations=0))


def test_a_task_that_failed_says_why():
    session = Session("device", "create", ("FAILED", "the laser is out"))
    with pytest.raises(RemoteError, match="failed: the laser is out"):
        get("braket-vqe").sample(pattern_model(), **on(session, **TURNED))
    with JobStore() as store:
        assert store.list()[0].state == "failed"


def test_without_credentials_or_region(monkeypatch):
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    with pytest.raises(CredentialsError, match="there are no credentials for Amazon Braket"):
        get("braket-vqe").sample(small_model(), device="SV1")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIAPL4NTED012345678")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "pl4nted-secret-of-a-robot")
    with pytest.raises(CredentialsError, match="AWS_DEFAULT_REGION"):
        get("braket-vqe").sample(small_model(), device="SV1")


def test_without_a_network(monkeypatch):
    """The real client, and an address where nobody listens."""
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIAPL4NTED012345678")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "pl4nted-secret-of-a-robot")
    monkeypatch.setenv("BRAKET_ENDPOINT", "http://127.0.0.1:9")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    with pytest.raises(RemoteError, match="cannot be reached") as caught:
        get("braket-vqe").sample(small_model(), device="Garnet", timeout=0.2)
    assert "pl4nted" not in str(caught.value)


def test_pennylane_asks_nobody_before_it_may(monkeypatch):
    pytest.importorskip("braket.pennylane_plugin", reason="the plugin is absent")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    sampler = get("pennylane-vqe")
    given = {"device": "braket.aws.qubit", "device_options": {"device_arn": SV1}}
    with pytest.raises(CredentialsError, match="there are no credentials for Amazon Braket"):
        sampler.sample(small_model(), **given)
    with pytest.raises(InputError, match="device"):
        sampler.sample(small_model(), device="braket.aws.qubit")
    with pytest.raises(BackendError, match="retired"):
        sampler.sample(
            small_model(),
            device="braket.aws.qubit",
            device_options={"device_arn": f"{SV1[:-3]}tn1"},
        )
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIAPL4NTED012345678")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "pl4nted-secret-of-a-robot")
    assert sampler.runs_remotely(**given)
    with pytest.raises(BackendError, match="cannot be estimated"):
        sampler.sample(small_model(), **given, max_cost=100.0)
    found = sampler.sample(small_model(), **given, dry_run=True)
    assert len(found) == 0
    assert found.info["remote"]["estimate"]["usd"] is None
    with pytest.raises(InputError, match="waits for its devices"):
        sampler.sample(small_model(), **given, wait=False)


def test_pennylane_runs_a_task_by_the_plugin():
    pytest.importorskip("braket.pennylane_plugin", reason="the plugin is absent")
    session = Session("device", "create", *("COMPLETED",) * 9)
    options = {"device_arn": SV1, "aws_session": session}
    found = get("pennylane-vqe").sample(
        pattern_model(), device="braket.aws.qubit", device_options=options, num_reads=20, **TURNED
    )
    assert (found.record.energy == -3.0).all()
    assert found.info["parameters"] == TURNED["initial_parameters"]


def test_only_known_simulators_are_local() -> None:
    from qrobot.backends.pennylane.sampler import is_local

    assert is_local("lightning.qubit")
    assert is_local("braket.local.qubit")
    for device in ("ionq.qpu", "qiskit.remote", "braket.aws.qubit", "cirq.pasqal", object()):
        assert not is_local(device)


@needs("pennylane")
def test_what_is_no_device_is_refused_before_any_search() -> None:
    for device in (3, "ionq.qpu"):
        with pytest.raises(InputError, match="not a PennyLane device"):
            get("pennylane-qaoa").sample(small_model(), device=device)
