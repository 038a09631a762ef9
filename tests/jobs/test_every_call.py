"""Every call to a service goes through `with_retries`: retried, redacted, told as ours."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import qrobot
from qrobot.cli import main

PACKAGE = Path(qrobot.__file__).parent
TOKEN = "DEV-pl4ntedpl4ntedpl4nted0123456789"

WRAPPERS = {"with_retries", "_call"}
SERVICE_CALLS = {"poll", "submit", "cancel", "find", "fetch", "estimate", "make_child"}
UNWRAPPED = {
    # The sampler runs on this machine there.
    ("planning/remote_jobs.py", "estimate"),
    # A function that is given to the wrapper by name.
    ("jobs/driver.py", "submit"),
    # The door's own functions of these names, which wrap what they call.
    ("planning/remote_jobs.py", "fetch"),
    ("cli/jobs.py", "cancel"),
    ("cli/jobs.py", "fetch"),
}
SDK_NAMES = {
    "AwsDevice", "AwsQuantumTask", "AwsSession", "DWaveSampler", "LeapHybridCQMSampler",
    "LeapHybridNLSampler", "LeapHybridSampler", "Problems", "QiskitRuntimeService",
}  # fmt: skip
"""What reaches a network: named only where its calls are wrapped."""
AT_HOME = {
    "AwsDevice": {"devices.py"},
    "AwsQuantumTask": {"jobs.py"},
    "AwsSession": {"devices.py"},
    "Problems": {"client.py"},
    "QiskitRuntimeService": {"jobs.py"},
}


class Calls(ast.NodeVisitor):
    """Finds calls of a service that no wrapper makes: only what it is given to call later is."""

    def __init__(self) -> None:
        self.wrapped = False
        self.found: set[str] = set()

    def visit_Call(self, node: ast.Call) -> None:
        function = node.func
        name = function.attr if isinstance(function, ast.Attribute) else None
        name = function.id if isinstance(function, ast.Name) else name
        method = isinstance(function, ast.Attribute)
        if method and name in SERVICE_CALLS and not self.wrapped:
            self.found.add(str(name))
        outside = self.wrapped
        for argument in [*node.args, *(keyword.value for keyword in node.keywords)]:
            self.wrapped = outside or (name in WRAPPERS and isinstance(argument, ast.Lambda))
            self.visit(argument)
        self.wrapped = outside
        self.visit(function)


def test_no_call_of_a_service_is_outside_the_wrapper() -> None:
    outside = set()
    for room in ("planning", "jobs", "cli"):
        also = [PACKAGE / "backends/jobs.py"] if room == "planning" else []
        for path in [*(PACKAGE / room).glob("*.py"), *also]:
            calls = Calls()
            calls.visit(ast.parse(path.read_text()))
            outside |= {(path.relative_to(PACKAGE).as_posix(), name) for name in calls.found}
    services = {
        (f"jobs/{name}.py", call) for name in ("circuits", "service") for call in SERVICE_CALLS
    }
    assert outside - services <= UNWRAPPED


def test_what_reaches_a_network_is_named_at_home_only() -> None:
    for path in PACKAGE.rglob("*.py"):
        if "health" in path.parts:
            continue
        tree = ast.parse(path.read_text())
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        names |= {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        for name in names & SDK_NAMES:
            inside = [
                f
                for f in ast.walk(tree)
                if isinstance(f, ast.FunctionDef) and name in ast.unparse(f)
            ]
            if name in AT_HOME:
                assert path.name in AT_HOME[name], f"{path}: {name}"
            else:
                assert {f.name for f in inside} == {"make_child"}, f"{path}: {name}"


def test_a_call_outside_would_be_found() -> None:
    calls = Calls()
    calls.visit(ast.parse("with_retries(lambda: service.poll(job)); service.cancel(job)"))
    assert calls.found == {"cancel"}
    calls.visit(ast.parse("with_retries(service.find(job)); f(lambda: service.estimate(job))"))
    assert calls.found == {"cancel", "find", "estimate"}


BACKENDS = ("dwave-qpu", "leap-bqm", "leap-cqm", "leap-nl")
ASKED = {
    "solve": ("--deadline", "5"),
    "dry run": ("--dry-run",),
    "dry run with a budget": ("--dry-run", "--max-cost", "1"),
    "hand over": ("--no-wait",),
}


def answer(*words: str) -> tuple[int, str]:
    """Return the exit code of the command line and all that it prints."""

    @click.command(context_settings={"ignore_unknown_options": True})
    @click.argument("rest", nargs=-1, type=click.UNPROCESSED)
    def command(rest: tuple[str, ...]) -> None:
        main(list(rest))

    done = CliRunner().invoke(command, list(words))
    return done.exit_code, done.output


@pytest.fixture
def question(tmp_path: Path) -> str:
    path = tmp_path / "question.json"
    path.write_text(
        json.dumps(
            {
                "schema": "qrobot.instance/1",
                "warehouse": {"kind": "floor", "depot": {"x": 0, "y": 0}},
                "items": [{"id": "a", "weight": 1, "at": {"x": 3, "y": 0}}],
                "robots": {"count": 1, "capacity": 1},
            }
        )
    )
    return str(path)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("flags", ASKED.values(), ids=ASKED)
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_token_that_is_refused_and_echoed(
    backend: str, flags: tuple[str, ...], question: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dwave.system", reason="the extra dwave is not installed")
    from jobs.fake_sapi import serving

    with serving() as server:
        server.sapi.refuse = True
        monkeypatch.setenv("DWAVE_API_ENDPOINT", server.url)
        monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
        code, text = answer("--debug", "solve", question, "--backend", backend, *flags)
    assert code == 3, text
    assert "refused the credentials" in text
    assert TOKEN not in text


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("backend", ["dwave-qpu", "leap-bqm"])
@pytest.mark.parametrize("flags", [("--dry-run",), ("--deadline", "3")], ids=["dry run", "solve"])
def test_a_service_without_a_network(
    backend: str, flags: tuple[str, ...], question: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dwave.system", reason="the extra dwave is not installed")
    monkeypatch.setenv("DWAVE_API_ENDPOINT", "http://127.0.0.1:9/")
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
    monkeypatch.setattr("qrobot.jobs.retry.time.sleep", lambda _: None)
    code, text = answer("--debug", "solve", question, "--backend", backend, *flags)
    assert code == 3, text
    assert "cannot be reached" in text
    assert TOKEN not in text


JOBS = {
    "list": ("jobs", "list", "--refresh"),
    "fetch": ("jobs", "fetch"),
    "cancel": ("jobs", "cancel"),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("network", [True, False], ids=["refused", "no network"])
@pytest.mark.parametrize("backend", ["dwave-qpu", "leap-bqm"])
def test_jobs_of_a_service_that_refuses_or_is_away(
    backend: str, network: bool, question: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dwave.system", reason="the extra dwave is not installed")
    from jobs.fake_sapi import serving

    from qrobot.jobs import JobStore

    monkeypatch.setattr("qrobot.jobs.retry.time.sleep", lambda _: None)
    with serving() as server:
        server.sapi.hold = True
        monkeypatch.setenv("DWAVE_API_ENDPOINT", server.url)
        monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
        code, text = answer("solve", question, "--backend", backend, "--no-wait")
        assert code == 0, text
        with JobStore() as store:
            (job,) = store.list()
        server.sapi.refuse = network
        if not network:
            monkeypatch.setenv("DWAVE_API_ENDPOINT", "http://127.0.0.1:9/")
        for name, words in JOBS.items():
            given = () if name == "list" else (job.id,)
            code, text = answer("--debug", *words, *given)
            assert code == (0 if name == "list" else 3), text
            assert ("refused the credentials" if network else "cannot be reached") in text
            assert TOKEN not in text
    code, text = answer("--debug", "doctor")
    assert TOKEN not in text


def test_what_circuits_are_made_for_is_asked_in_the_wrapper() -> None:
    """A real machine fetches its target from the service when circuits are transpiled for it."""
    from qrobot.backends.gate.sampler import VariationalSampler

    class Away(VariationalSampler):
        sdk, algorithm, extra = "away", "qaoa", "ibm"

        def check(self, qubits, options):
            return False

        def connect(self, qubits, options, job_options):
            return object()

        def engine(self, circuit, options):
            raise AssertionError("it is remote")

        def remote_engine(self, machine, circuit, options):
            raise type("SomeError", (Exception,), {"status_code": 401})(f"token={TOKEN}")

    import dimod

    bqm = dimod.BinaryQuadraticModel({0: 1.0}, {}, 0.0, "BINARY")
    for ask in (Away().sample, Away().estimate):
        with pytest.raises(qrobot.CredentialsError) as caught:
            ask(bqm, evaluations=0)
        assert TOKEN not in str(caught.value)
        assert caught.value.__context__ is None


def test_the_kind_of_a_machine_is_told_without_asking_it() -> None:
    pytest.importorskip("qiskit", reason="the extra qiskit is not installed")
    from qrobot.backends.qiskit.runtime import backend_of

    class Machine:
        @property
        def target(self) -> None:
            raise ConnectionError("asked over the network")

    machine = Machine()
    assert backend_of(machine) is machine
    with pytest.raises(qrobot.InputError, match="not a backend, session or batch"):
        backend_of(object())
