"""When a remote backend fails: the local one that answers instead, and a note that says so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from qrobot.errors import BackendError

__all__ = ["Fallback", "run_with_fallback"]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Fallback(Generic[T]):
    """An answer, who gave it, and what the reader must be told.

    Parameters
    ----------
    value
        What the call returned.
    backend
        Name of the backend that answered.
    note
        ``None`` when the asked one answered; otherwise a sentence for the result's notes.
    """

    value: T
    backend: str
    note: str | None = None


def run_with_fallback(
    primary: Callable[[], T],
    fallback_name: str | None = None,
    fallback: Callable[[str], T] | None = None,
    *,
    primary_name: str,
) -> Fallback[T]:
    """Call a backend; when it fails, call the fallback and say so.

    Parameters
    ----------
    primary
        The work with the backend that was asked for.
    fallback_name
        Backend to use instead; ``None``: a failure is a failure.
    fallback
        The work with the backend of that name.
    primary_name
        For the note.

    Raises
    ------
    BackendError
        When the primary failed and there is no fallback, or that failed too: the message
        then names both. Bad input and infeasible instances are never retried elsewhere.
    """
    try:
        return Fallback(primary(), primary_name)
    except BackendError as error:
        if fallback_name is None or fallback is None or fallback_name == primary_name:
            raise
        reason = str(error)
    try:
        value = fallback(fallback_name)
    except BackendError as error:
        second = str(error)
    else:
        note = f"{primary_name} failed, {fallback_name} answered instead: {reason}"
        return Fallback(value, fallback_name, note)
    raise BackendError(
        f"{primary_name} failed ({reason}), and so did the fallback {fallback_name} ({second})"
    )
