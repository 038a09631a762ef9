"""The way to IBM Quantum: the user's account, and a machine of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qrobot._extras import load
from qrobot.errors import BackendError, CredentialsError
from qrobot.jobs.credentials import require
from qrobot.jobs.retry import Backoff, with_retries

__all__ = ["TITLE", "machine", "service"]

TITLE = "IBM Quantum"

_ABSENT = "QiskitBackendNotFoundError"


def service(backoff: Backoff | None = None, stop: Callable[[], bool] | None = None) -> Any:
    """Return a ``QiskitRuntimeService`` from the SDK's own files and variables.

    Raises
    ------
    CredentialsError
        When there is no account (told without asking a network), or it is refused.
    RemoteError
        When the service cannot be reached.
    """
    require("ibm")
    refused = ""

    def opening() -> Any:
        nonlocal refused
        service = load("qiskit_ibm_runtime", TITLE).QiskitRuntimeService
        try:
            return service()
        except (AttributeError, KeyError, TypeError) as error:  # a bogus instance raises these
            refused = type(error).__name__
            return None

    found = with_retries(opening, what=TITLE, backoff=backoff, stop=stop)
    if found is None:
        raise CredentialsError(
            f"{TITLE} did not accept the account ({refused}: most often a wrong instance); save"
            " it again with QiskitRuntimeService.save_account"
        )
    return found


def machine(
    name: str,
    qubits: int,
    *,
    backoff: Backoff | None = None,
    stop: Callable[[], bool] | None = None,
) -> Any:
    """Return a backend of the user's account.

    Parameters
    ----------
    name
        Its name; empty: the least busy one that is large enough.
    qubits
        That it must have.
    backoff, stop
        Of the calls.

    Raises
    ------
    BackendError
        When the account has no such machine.
    CredentialsError, RemoteError
        See `service`.
    """
    opened = service(backoff, stop)

    def asking() -> Any:
        try:
            if name:
                return opened.backend(name)
            return opened.least_busy(min_num_qubits=qubits, operational=True, simulator=False)
        except Exception as error:
            if type(error).__name__ == _ABSENT:
                return None
            raise

    found = with_retries(asking, what=TITLE, backoff=backoff, stop=stop)
    if found is None:
        wanted = f"is named {name!r}" if name else f"has {qubits} qubits or more"
        raise BackendError(f"no machine of this {TITLE} account {wanted}")
    return found
