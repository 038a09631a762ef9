"""Calls to other machines: tried again where that is safe, and turned into our errors.

Errors are told apart by the names of their classes and by their status codes, so that no
SDK must be imported to understand one.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar

from qrobot.errors import CredentialsError, QRobotError, RemoteError
from qrobot.jobs.redaction import redact

__all__ = ["Backoff", "Kind", "classify", "translate", "with_retries"]

T = TypeVar("T")

Kind = Literal["credentials", "refused", "lost", "busy", "final"]
"""``refused``: it never arrived; ``lost``: it may have arrived; ``busy``: come back later."""

_CREDENTIALS = {
    "CredentialRetrievalError", "ForbiddenException", "IBMNotAuthorizedError",
    "InvalidAccountError", "NoAuthTokenError", "NoCredentialsError", "NoRegionError",
    "PartialCredentialsError", "ProfileNotFound", "ResourceAccessForbiddenError",
    "ResourceAuthenticationError", "SolverAuthenticationError", "UnauthorizedSSOTokenError",
}  # fmt: skip
_CREDENTIAL_CODES = {
    "AccessDenied", "AccessDeniedException", "AuthFailure", "ExpiredToken",
    "ExpiredTokenException", "InvalidAccessKeyId", "InvalidClientTokenId",
    "InvalidSignatureException", "MissingAuthenticationToken", "SignatureDoesNotMatch",
    "UnrecognizedClientException",
}  # fmt: skip
_BUSY_CODES = {
    "RequestLimitExceeded", "Throttling", "ThrottlingException", "TooManyRequestsException",
}  # fmt: skip
_ARRIVED = {
    "ConnectionClosedError", "ConnectionResetError", "PollingTimeout", "ProtocolError",
    "ReadTimeout", "ReadTimeoutError", "RemoteDisconnected",
}  # fmt: skip
"""The connection stood: whatever else the chain tells of earlier tries, it may have arrived."""
_REFUSED = {
    "ConnectTimeout", "ConnectTimeoutError", "ConnectionRefusedError", "EndpointConnectionError",
    "NameResolutionError", "NewConnectionError", "gaierror",
}  # fmt: skip
_LOST = {
    "ConnectionClosedError", "ConnectionError", "HTTPClientError", "InternalServerError",
    "PollingTimeout", "ProtocolError", "ReadTimeout", "ReadTimeoutError", "RequestTimeout",
    "RequestsApiError", "Timeout", "TimeoutError",
}  # fmt: skip
_SILENT = _REFUSED | _ARRIVED | {
    "ConnectionError", "ProxyError", "RequestTimeout", "SSLError", "Timeout", "TimeoutError",
}  # fmt: skip
"""Nobody answered: whatever else an SDK calls it, it is not a refusal."""
_BUSY_STATUS = {425, 429}
"""The service says that it did not take it. A gateway's 502 to 504, or a 500, says nothing."""


@dataclass(frozen=True, slots=True)
class Backoff:
    """How long to wait between tries.

    Parameters
    ----------
    attempts
        Tries in all.
    first
        Longest wait after the first try, seconds; it doubles after each.
    ceiling
        Longest wait of all, seconds.
    timeout
        No try begins after so many seconds; ``None``: no limit.
    """

    attempts: int = 4
    first: float = 0.5
    ceiling: float = 20.0
    timeout: float | None = None

    def wait(self, attempt: int, chance: float) -> float:
        """Return the seconds to wait after a try (0 is the first), with full jitter.

        At least a tenth of the longest wait, so that tries never follow at once.
        """
        longest = min(self.ceiling, self.first * 2.0**attempt)
        return float(longest * (0.1 + 0.9 * chance))


def _chain(error: BaseException) -> list[BaseException]:
    """Return an error and what it came from, wrapped reasons of HTTP libraries included."""
    found: list[BaseException] = []
    todo: list[object] = [error]
    while todo and len(found) < 20:
        one = todo.pop(0)
        if not isinstance(one, BaseException) or any(one is other for other in found):
            continue
        found.append(one)
        todo += [one.__cause__, one.__context__, getattr(one, "reason", None), *one.args]
    return found


def _status(error: BaseException) -> int | None:
    answer = getattr(error, "response", None)
    if isinstance(answer, dict):
        code = answer.get("ResponseMetadata", {}).get("HTTPStatusCode")
    else:
        code = getattr(answer, "status_code", None)
    for value in (code, getattr(error, "error_code", None), getattr(error, "status_code", None)):
        if isinstance(value, int) and 400 <= value < 600:
            return value
    return None


def _aws_code(error: BaseException) -> str:
    answer = getattr(error, "response", None)
    return str(answer.get("Error", {}).get("Code", "")) if isinstance(answer, dict) else ""


def classify(error: BaseException) -> Kind:
    """Return what kind of trouble an error of an SDK is."""
    chain = _chain(error)
    names = {cls.__name__ for one in chain for cls in type(one).__mro__}
    codes = {_aws_code(one) for one in chain}
    status = next((s for one in chain if (s := _status(one)) is not None), None)
    text = str(error).lower()
    # SDKs call it a wrong account too when nobody could be asked: only an answer refuses.
    silent = status is None and bool(names & _SILENT)
    if codes & _CREDENTIAL_CODES or status in (401, 403) or (names & _CREDENTIALS and not silent):
        return "credentials"
    if "token not defined" in text or "unable to find account" in text:
        return "credentials"
    if codes & _BUSY_CODES or status in _BUSY_STATUS:
        return "busy"
    if names & _ARRIVED or status == 408 or (status is not None and status >= 500):
        return "lost"
    if names & _REFUSED:
        return "refused"
    if names & _LOST:
        return "lost"
    return "final"


def translate(error: BaseException, what: str, attempts: int = 1) -> QRobotError:
    """Return our error for an SDK's: one sentence, no secret, no chain to one."""
    kind = classify(error)
    if kind != "credentials" and type(error).__name__ in _CREDENTIALS:
        # The SDK blames the account; what it came from is the truth.
        error = next((one for one in _chain(error) if type(one).__name__ in _SILENT), error)
    text = " ".join(redact(error).split())
    text = text if len(text) <= 300 else f"{text[:300]} ..."
    detail = f"{type(error).__name__}: {text}" if text else type(error).__name__
    tries = f" after {attempts} tries" if attempts > 1 else ""
    if kind == "credentials":
        return CredentialsError(
            f"{what} refused the credentials ({detail}); see 'qrobot doctor' for where they are"
        )
    if kind == "refused":
        return RemoteError(f"{what} cannot be reached{tries} ({detail}); check the network")
    if kind == "lost" and any(_status(one) is not None for one in _chain(error)):
        return RemoteError(f"{what} had trouble of its own{tries} ({detail}); try again later")
    if kind == "lost":
        return RemoteError(f"{what} did not answer in time{tries} ({detail}); try again later")
    if kind == "busy":
        return RemoteError(f"{what} is too busy{tries} ({detail}); try again later")
    return RemoteError(f"{what} failed{tries} ({detail})")


def with_retries(
    call: Callable[[], T],
    *,
    what: str,
    backoff: Backoff | None = None,
    idempotent: bool = True,
    stop: Callable[[], bool] | None = None,
    sleep: Callable[[float], object] = time.sleep,
    chance: Callable[[], float] = random.random,
) -> T:
    """Call another machine; try again where that helps and is safe.

    Parameters
    ----------
    call
        The call; it should have a timeout of its own.
    what
        Who is called, for messages: ``"D-Wave Leap"``.
    backoff
        How often and how long.
    idempotent
        False for a call that must not happen twice, such as submitting a job that bills:
        it is repeated only when it cannot have arrived.
    stop
        Asked before each wait; True ends the tries.
    sleep, chance
        For tests.

    Raises
    ------
    CredentialsError
        When the service refused the credentials; never retried.
    RemoteError
        When it failed for good.
    """
    plan = backoff or Backoff()
    begun = time.monotonic()
    attempt = 0
    while True:
        try:
            return call()
        except (QRobotError, KeyboardInterrupt):
            raise
        except Exception as error:
            kind = classify(error)
            trouble = translate(error, what, attempt + 1)
        # Outside of the handler: the error that is raised below carries no chain to the
        # SDK's own, whose text may hold a secret.
        again = kind in ("refused", "busy") or (kind == "lost" and idempotent)
        wait = plan.wait(attempt, chance())
        late = plan.timeout is not None and time.monotonic() - begun + wait > plan.timeout
        attempt += 1
        if not again or attempt >= plan.attempts or late or (stop is not None and stop()):
            raise trouble
        sleep(wait)
