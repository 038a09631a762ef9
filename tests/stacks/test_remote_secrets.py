"""Keys are planted, calls of the SDKs fail with texts that quote them, everything is searched."""

from __future__ import annotations

import importlib.util
import logging
from pathlib import Path

import pytest
from jobs.test_redaction import FORMS, TOKEN, everything, plant
from stacks.stacks import needs, small_model

from qrobot.backends import get
from qrobot.errors import QRobotError
from qrobot.jobs import JobStore

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::SyntaxWarning"),
]

TEXT = f"header Authorization: AWS4 {TOKEN} refused; token={TOKEN}"

QUICK = {"evaluations": 0, "num_reads": 10}


@pytest.fixture
def planted(home, monkeypatch):
    plant(home)
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", TOKEN)
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIAPL4NTED012345678")
    monkeypatch.setenv("QISKIT_IBM_TOKEN", TOKEN)
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
    return home


class Search:
    """Gathers what came out, and looks for the token in it."""

    def __init__(self, capfd, caplog):
        self.capfd, self.caplog, self.texts, self.failures = capfd, caplog, [], 0
        caplog.set_level(logging.INFO)

    def refused(self, call):
        with pytest.raises(QRobotError) as caught:
            call()
        self.failures += 1
        self.texts.append(everything(caught.value))
        assert caught.value.__cause__ is None
        assert caught.value.__context__ is None

    def done(self, failures):
        assert self.failures == failures
        self.texts += [*self.capfd.readouterr(), self.caplog.text]
        with JobStore() as store:
            for job in store.list():
                answer = store.answer(job)
                self.texts += [repr(job), repr(None if answer is None else answer.info)]
            raw = b"".join(file.read_bytes() for file in store.path.parent.glob("jobs*"))
        for form in FORMS:
            assert form.encode() not in raw
            for text in self.texts:
                assert form not in text


@pytest.fixture
def search(planted, capfd, caplog):
    return Search(capfd, caplog)


@needs("braket")
def test_braket(search):
    from stacks.cloud import SV1, Session

    sampler, bqm = get("braket-vqe"), small_model()
    operations = ["get_device", "create_quantum_task", "get_quantum_task"]
    for k, operation in enumerate(operations):
        for code, status in (("AccessDeniedException", 403), ("ValidationException", 400)):
            script = [*["device", "create"][:k], ("error", operation, code, TEXT, status)]
            given = {"device": SV1, "device_options": {"aws_session": Session(*script)}}
            search.refused(lambda given=given: sampler.sample(bqm, **given, **QUICK))

    def unreadable(*_args):
        raise RuntimeError(TEXT)

    session = Session("device", "create", "COMPLETED", "COMPLETED")
    session.retrieve_s3_object_body = unreadable
    given = {"device": SV1, "device_options": {"aws_session": session}}
    search.refused(lambda: sampler.sample(bqm, **given, **QUICK))
    session = Session("device", "create", ("FAILED", TEXT))
    given = {"device": SV1, "device_options": {"aws_session": session}}
    search.refused(lambda: sampler.sample(bqm, **given, **QUICK))
    # An answer that is right, with a context that is not.
    session = Session("device", "create", *("COMPLETED",) * 3)
    given = {"device": SV1, "device_options": {"aws_session": session}}
    found = sampler.sample(bqm, **given, **QUICK, context={"note": TEXT, "info": TEXT})
    search.texts.append(repr(found.info))
    search.done(8)


@needs("qiskit")
def test_ibm(search, monkeypatch):
    if importlib.util.find_spec("qiskit_ibm_runtime") is None:
        pytest.skip("the extra ibm is not installed")
    import qiskit_ibm_runtime
    from qiskit_ibm_runtime.executor_sampler import Sampler
    from qiskit_ibm_runtime.fake_provider import FakeManilaV2
    from qiskit_ibm_runtime.fake_provider.local_runtime_job import LocalRuntimeJob

    sampler, bqm, machine = get("qiskit-vqe"), small_model(), FakeManilaV2()

    def refuse(*_args, **_options):
        raise ValueError(TEXT)

    with monkeypatch.context() as patch:
        patch.setattr(qiskit_ibm_runtime, "QiskitRuntimeService", refuse)
        search.refused(lambda: sampler.sample(bqm, device="ibm", **QUICK))
    for owner, name in ((Sampler, "run"), (LocalRuntimeJob, "result"), (LocalRuntimeJob, "status")):
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, refuse)
            search.refused(lambda: sampler.sample(bqm, mode=machine, **QUICK))
    search.done(4)


@needs("pennylane")
def test_pennylane(search):
    import pennylane as qml

    class Broken(qml.devices.Device):
        name = "broken.remote"

        def execute(self, circuits, execution_config=None):
            raise RuntimeError(TEXT)

    sampler, bqm = get("pennylane-vqe"), small_model()
    search.refused(lambda: sampler.sample(bqm, device=Broken(wires=3), **QUICK))
    if importlib.util.find_spec("braket") is not None:
        pytest.importorskip("braket.pennylane_plugin", reason="the plugin is absent")
        from stacks.cloud import SV1, Session

        error = ("error", "get_device", "AccessDeniedException", TEXT, 403)
        options = {"device_arn": SV1, "aws_session": Session(error)}
        given = {"device": "braket.aws.qubit", "device_options": options}
        search.refused(lambda: sampler.sample(bqm, **given, **QUICK))
    search.done(2 if search.failures == 2 else 1)


@needs("braket")
def test_the_command_line_with_debug(search, monkeypatch, capfd):
    from stacks.cloud import Session

    from qrobot.cli.main import main

    error = ("error", "get_device", "ValidationException", TEXT, 400)
    monkeypatch.setattr("qrobot.backends.braket.devices.session", lambda region: Session(error))
    example = Path(__file__).parents[2] / "examples" / "paper-4-items.json"
    words = ["--debug", "solve", str(example), "--backend", "braket-qaoa"]
    with pytest.raises(SystemExit) as ended:
        main([*words, "-O", "device=SV1", "-O", "evaluations=0"])
    assert ended.value.code == 3
    shown = capfd.readouterr()
    assert "Traceback" in shown.err  # so the search had something to look at
    assert "ValidationException" in shown.err
    search.texts += [*shown]
    search.done(0)
