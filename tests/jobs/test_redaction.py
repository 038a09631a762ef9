"""Secrets are planted everywhere, then everything is searched."""

from __future__ import annotations

import base64
import json
import traceback
import urllib.parse
from pathlib import Path

import dimod
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jobs.fake_service import FileService
from jobs.homeless import homeless

from qrobot.errors import CredentialsError, QRobotError
from qrobot.jobs import (
    JobOptions,
    JobStore,
    presence,
    redact,
    redact_data,
    register_secret,
    run_job,
)
from qrobot.jobs.credentials import require
from qrobot.jobs.redaction import MASK

TOKEN = "pl4nted/S3cret+value=="
FORMS = [
    TOKEN,
    urllib.parse.quote(TOKEN, safe=""),
    base64.b64encode(TOKEN.encode()).decode(),
]

SHAPES = [
    "DEV-0123456789abcdef0123456789abcdef01234567",
    "AKIAIOSFODNN7EXAMPLE",
    "eyJhbGciOiJIUzI1NiJ9.eyJzdWIiOiIxMjM0In0.c2lnbmF0dXJl",
    "X-Auth-Token: something-odd",
    '{"token": "something-odd"}',
    "https://user:something-odd@host/path",
    "Authorization: Bearer something-odd",
    "api_key=something-odd&x=1",
    "aws_secret_access_key = something-odd",
]


@pytest.mark.parametrize("text", SHAPES)
def test_tokens_are_known_by_their_shape(text: str) -> None:
    clean = redact(f"it said {text} and ended")
    assert MASK in clean
    assert "something-odd" not in clean
    assert text not in clean


def test_ordinary_sentences_stay() -> None:
    for text in (
        "5 items need 25 qubits; use backend auto",
        "the token is absent",
        "the wait for D-Wave QPU took longer than 5 s; 'qrobot jobs fetch qr-3f9a2c71d0b4' gets it",
        "keyboard: a key was pressed",
        "4bbe3463-b45c-4e64-9a99-5c0b36bdb2d3",
        "arn:aws:braket:us-east-1::device/qpu/ionq/Forte-1",
    ):
        assert redact(text) == text


@pytest.mark.parametrize(
    "variable", ["DWAVE_API_TOKEN", "QISKIT_IBM_TOKEN", "AWS_SECRET_ACCESS_KEY"]
)
def test_variables_are_known_by_value(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, TOKEN)
    for form in FORMS:
        assert TOKEN not in redact(f"<{form}>")
        assert form not in redact(f"<{form}>")


def plant(home: Path) -> None:
    """Put the token into every standard file."""
    for path, text in {
        ".config/dwave/dwave.conf": f"[defaults]\ntoken = {TOKEN}\n",
        ".qiskit/qiskit-ibm.json": json.dumps({"default": {"token": TOKEN, "channel": "x"}}),
        ".aws/credentials": f"[default]\naws_secret_access_key = {TOKEN}\n",
    }.items():
        file = home / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(0o600)


def test_files_are_known_by_value(home: Path) -> None:
    for service in ("dwave", "ibm", "aws"):
        assert not presence(service).present
        with pytest.raises(CredentialsError, match="there are no credentials for"):
            require(service)
    plant(home)
    for service in ("dwave", "ibm", "aws"):
        found = presence(service)
        assert found.present
        assert not found.open_to_others
        assert TOKEN not in repr(found)
    assert redact_data({"a": [f"x{TOKEN}y", 1, None]}) == {"a": [f"x{MASK}y", 1, None]}


def test_broken_credential_files_are_no_trouble(home: Path) -> None:
    plant(home)
    for path in (".config/dwave/dwave.conf", ".qiskit/qiskit-ibm.json", ".aws/credentials"):
        (home / path).write_bytes(b"\xff[half")
    assert not presence("dwave").present
    assert redact("fine") == "fine"


@pytest.mark.parametrize("named", [False, True])
def test_a_user_without_a_home_has_no_credentials_and_no_trouble(
    named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    homeless(monkeypatch)
    for variable in (
        "DWAVE_CONFIG_FILE", "QISKIT_IBM_CREDENTIALS_FILE", "AWS_SHARED_CREDENTIALS_FILE",
        "AWS_CONFIG_FILE",
    ):  # fmt: skip
        if named:
            monkeypatch.setenv(variable, "~nobody-of-this-name/credentials")
        else:
            monkeypatch.delenv(variable, raising=False)
    assert redact("fine") == "fine"
    for service in ("dwave", "ibm", "aws"):
        assert not presence(service).present


def test_files_open_to_others_are_told(home: Path) -> None:
    plant(home)
    (home / ".aws" / "credentials").chmod(0o644)
    assert presence("aws").open_to_others


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(st.text(st.characters(min_codepoint=33, max_codepoint=126), min_size=8), st.text())
def test_a_registered_secret_never_passes(secret: str, around: str) -> None:
    register_secret(secret)
    try:
        assert secret not in redact(f"{around} {secret} {around}") or secret in MASK
    finally:
        from qrobot.jobs import redaction

        redaction._registered.discard(secret)


def everything(error: BaseException) -> str:
    """All that a traceback, a debugger or a log could show of an error."""
    texts = ["".join(traceback.format_exception(error))]
    one: BaseException | None = error
    while one is not None:
        texts += [str(one), repr(one), repr(one.args), repr(vars(one))]
        one = one.__cause__ or one.__context__
    return "\n".join(texts)


def test_a_planted_secret_is_nowhere(
    tmp_path: Path, home: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    plant(home)
    bqm = dimod.BQM({"a": 1.0}, {}, 0.0, "BINARY")
    path = tmp_path / "jobs.sqlite3"
    texts = []
    with JobStore(path) as store:
        for step in ("estimate", "submit", "submitted", "poll", "fetch"):
            service = FileService(tmp_path / "service")
            service.errors = {step: [ValueError(f"header X-Auth-Token {TOKEN} refused")] * 9}
            with pytest.raises(QRobotError) as caught:
                run_job(service, bqm, store=store)
            texts.append(everything(caught.value))
        service = FileService(tmp_path / "service")
        fetch = service.fetch

        def leaky(job):
            answer = fetch(job)
            answer.samples.info["request"] = {"headers": {"X-Auth-Token": TOKEN}, TOKEN: 1}
            return answer

        service.fetch = leaky
        service.poll = lambda job: ("done", f"finished with {TOKEN}")
        samples = run_job(service, bqm, JobOptions(context={"note": TOKEN}), store=store)
        texts.append(repr(samples.info))
        texts += [repr(job) for job in store.list()]
        texts.append(repr(store.answer(store.list()[0]).info))
        raw = b"".join(file.read_bytes() for file in tmp_path.glob("jobs.sqlite3*"))
    texts += list(capfd.readouterr())
    texts.append(Path("/proc/self/cmdline").read_text())
    for form in FORMS:
        assert form.encode() not in raw
        for text in texts:
            assert form not in text
    assert MASK in "".join(texts)


@pytest.mark.parametrize("scheme", ["apikey", "Basic", "Bearer", "token"])
def test_what_follows_the_scheme_of_a_header_is_masked(scheme: str) -> None:
    assert "Zx81KkPq77LmN0aa" not in redact(f"Authorization: {scheme} Zx81KkPq77LmN0aa")
