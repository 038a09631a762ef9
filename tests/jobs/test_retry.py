"""Tries again where that helps and is safe; our errors, without a chain to the SDK's."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.errors import BackendError, CredentialsError, InputError, RemoteError
from qrobot.jobs import Backoff, Estimate, check_budget, with_retries
from qrobot.jobs.cost import by_shots, by_time, price
from qrobot.jobs.retry import classify, translate
from qrobot.planning.solving import run_with_fallback


class ClientError(Exception):
    """Shaped like botocore's."""

    def __init__(self, code: str, status: int) -> None:
        super().__init__(f"An error occurred ({code})")
        self.response = {"Error": {"Code": code}, "ResponseMetadata": {"HTTPStatusCode": status}}


class SolverAuthenticationError(Exception):
    pass


class RequestTimeout(Exception):  # noqa: N818
    pass


def named(name: str, *args: object) -> Exception:
    error: Exception = type(name, (Exception,), {})(*args)
    return error


KINDS = [
    (SolverAuthenticationError("no"), "credentials"),
    (ValueError("API token not defined"), "credentials"),
    (ClientError("AccessDeniedException", 400), "credentials"),
    (ClientError("UnrecognizedClientException", 400), "credentials"),
    (ClientError("ThrottlingException", 400), "busy"),
    (ClientError("ValidationException", 400), "final"),
    (named("NoCredentialsError"), "credentials"),
    # Qiskit Runtime says so where nobody could be asked.
    (
        named("InvalidAccountError", named("ConnectionError", named("NameResolutionError"))),
        "refused",
    ),
    (named("InvalidAccountError", named("ReadTimeout")), "lost"),
    (named("InvalidAccountError", ClientError("Forbidden", 403)), "credentials"),
    (ConnectionRefusedError(111, "refused"), "refused"),
    (named("ConnectionError", named("MaxRetryError", named("NewConnectionError"))), "refused"),
    (RequestTimeout("late"), "lost"),
    (TimeoutError(), "lost"),
    (ConnectionResetError(), "lost"),
    (ClientError("InternalServerException", 500), "lost"),
    (ClientError("ServiceUnavailable", 503), "lost"),
    (ClientError("Whatever", 429), "busy"),
    (named("ReadTimeout", named("NewConnectionError")), "lost"),
    (AttributeError("'NoneType' object has no attribute 'x'"), "final"),
]


@pytest.mark.parametrize(("error", "kind"), KINDS, ids=lambda x: repr(x)[:40])
def test_errors_are_told_apart(error: Exception, kind: str) -> None:
    assert classify(error) == kind


def failing(errors: list[Exception]) -> tuple[list[int], object]:
    calls: list[int] = []

    def call() -> str:
        calls.append(1)
        if len(calls) <= len(errors):
            raise errors[len(calls) - 1]
        return "done"

    return calls, call


def test_transient_trouble_is_tried_again_with_growing_waits() -> None:
    calls, call = failing([RequestTimeout(), RequestTimeout(), ConnectionRefusedError()])
    waits: list[float] = []
    found = with_retries(call, what="X", sleep=waits.append, chance=lambda: 1.0)
    assert found == "done"
    assert len(calls) == 4
    assert waits == [0.5, 1.0, 2.0]


def test_what_may_have_arrived_is_not_sent_twice() -> None:
    calls, call = failing([RequestTimeout()])
    with pytest.raises(RemoteError, match="X did not answer in time"):
        with_retries(call, what="X", idempotent=False, sleep=lambda _: None)
    assert len(calls) == 1
    calls, call = failing([ConnectionRefusedError()])
    assert with_retries(call, what="X", idempotent=False, sleep=lambda _: None) == "done"


def test_refused_credentials_are_not_tried_again_and_leave_no_chain() -> None:
    calls, call = failing([SolverAuthenticationError("token=abcdef123456 is invalid")])
    with pytest.raises(CredentialsError, match="refused the credentials") as caught:
        with_retries(call, what="X")
    assert len(calls) == 1
    assert caught.value.__cause__ is None
    assert caught.value.__context__ is None
    assert "abcdef123456" not in str(caught.value)


def test_a_timeout_and_a_stop_end_the_tries() -> None:
    calls, call = failing([RequestTimeout()] * 9)
    with pytest.raises(RemoteError):
        with_retries(call, what="X", backoff=Backoff(timeout=0.01), chance=lambda: 1.0)
    assert len(calls) == 1
    with pytest.raises(RemoteError):
        with_retries(call, what="X", stop=lambda: True)
    assert len(calls) == 2


def test_our_own_errors_and_interrupts_pass() -> None:
    for error in (InputError("x"), KeyboardInterrupt()):

        def call(error: BaseException = error) -> None:
            raise error

        with pytest.raises(type(error)):
            with_retries(call, what="X")


@given(st.integers(0, 60), st.floats(0, 1))
def test_waits_stay_within_their_bounds(attempt: int, chance: float) -> None:
    plan = Backoff()
    longest = min(plan.ceiling, plan.first * 2.0**attempt)
    assert 0.1 * longest <= plan.wait(attempt, chance) <= longest * (1 + 1e-12)


def test_budgets() -> None:
    check_budget(Estimate(5.0), None)
    check_budget(Estimate(0.0), 0)
    with pytest.raises(BackendError, match=r"about 2 USD .* limit of 1 USD; nothing was submitted"):
        check_budget(by_time(2, 1, "QPU"), 1)
    with pytest.raises(BackendError, match="cannot be estimated"):
        check_budget(Estimate(None, None, "no price"), 1)
    with pytest.raises(InputError, match="amount of money"):
        check_budget(Estimate(1.0), float("nan"))
    assert by_shots(1000, 0.0009, 0.3).usd == pytest.approx(1.2)


def test_prices_can_be_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QROBOT_USD_PER_DWAVE_HOUR", "36")
    assert price("dwave-hour") == 36
    for wrong in ("much", "nan", "-1"):
        monkeypatch.setenv("QROBOT_USD_PER_DWAVE_HOUR", wrong)
        with pytest.raises(InputError, match="amount of money"):
            price("dwave-hour")


def test_a_fallback_answers_and_the_result_says_so() -> None:
    def broken() -> int:
        raise RemoteError("the network is down")

    assert run_with_fallback(lambda: 1, "neal", lambda _: 2, primary_name="qpu").note is None
    found = run_with_fallback(broken, "neal", lambda name: len(name), primary_name="qpu")
    assert (found.value, found.backend) == (4, "neal")
    assert found.note == "qpu failed, neal answered instead: the network is down"
    with pytest.raises(RemoteError, match="network is down"):
        run_with_fallback(broken, primary_name="qpu")

    def broken_too(_: str) -> int:
        raise BackendError("no memory")

    with pytest.raises(BackendError, match=r"network is down.*neal \(no memory\)"):
        run_with_fallback(broken, "neal", broken_too, primary_name="qpu")

    def bad() -> int:
        raise InputError("nonsense")

    with pytest.raises(InputError):
        run_with_fallback(bad, "neal", lambda _: 1, primary_name="qpu")


@pytest.mark.parametrize("status", [408, 500, 502, 503, 504])
def test_a_gateways_error_is_no_refusal(status: int) -> None:
    """A gateway's error says nothing about the job behind it, and a second one would bill."""
    for idempotent, most in ((False, 1), (True, 3)):
        sent = []

        def call(sent: list[int] = sent) -> None:
            sent.append(1)
            raise ClientError("Trouble", status)

        with pytest.raises(RemoteError):
            with_retries(
                call,
                what="Braket",
                idempotent=idempotent,
                backoff=Backoff(attempts=3),
                sleep=lambda _: None,
            )
        assert len(sent) == most


def blamed(cause: Exception) -> Exception:
    """Return what IBM's SDK raises when it could not ask anybody about the account."""
    kind = type("InvalidAccountError", (Exception,), {})
    error = kind("Please check that you are using a valid API token.")
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    "name", ["ConnectTimeout", "ConnectionError", "NameResolutionError", "ProxyError", "SSLError"]
)
def test_an_account_that_nobody_was_asked_about_is_not_refused(name: str) -> None:
    cause = type(name, (Exception,), {})("nobody is there")
    told = translate(blamed(cause), "IBM Quantum")
    assert isinstance(told, RemoteError)
    assert "nobody is there" in str(told)
    assert "valid API token" not in str(told)  # the account is not what is wrong


def test_an_account_that_the_service_refused_is_told() -> None:
    answer = type("HTTPError", (Exception,), {"status_code": 401})("401")
    for error in (blamed(answer), blamed(ValueError("bad"))):
        assert isinstance(translate(error, "IBM Quantum"), CredentialsError)


@pytest.mark.parametrize(
    ("status", "kind"), [(401, CredentialsError), (403, CredentialsError), (503, RemoteError)]
)
def test_plugins_tell_what_a_service_answered(status: int, kind: type[Exception]) -> None:
    from qrobot.backends.gate.engine import attempt

    secret = "DEV-pl4ntedpl4ntedpl4nted0123456789"

    def refused() -> None:
        raise type("SomeError", (Exception,), {"status_code": status})(f"token={secret}")

    with pytest.raises(kind) as caught:
        attempt("pennylane", "running the circuit", refused)
    assert secret not in str(caught.value)
    assert caught.value.__context__ is None
