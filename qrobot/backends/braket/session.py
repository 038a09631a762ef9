"""The way to Amazon Braket: a session with credentials, and a device that is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qrobot._extras import load
from qrobot.errors import BackendError, CredentialsError
from qrobot.jobs.credentials import SERVICES, presence
from qrobot.jobs.redaction import mask_logs, register_secret
from qrobot.jobs.retry import Backoff, with_retries

__all__ = [
    "TITLE",
    "check_credentials",
    "check_status",
    "open_device",
    "properties_of",
    "session",
]

TITLE = "Amazon Braket"


def check_credentials() -> None:
    """Refuse when boto3 would find no credentials; no service is asked for that.

    Where neither file nor variable is found, boto3 asks the machine itself, which may have a
    role of its own (the metadata address of EC2, one second).

    Raises
    ------
    CredentialsError
        When there are none.
    """
    if presence("aws").present:
        return
    if _sdk("boto3").Session().get_credentials() is None:
        raise CredentialsError(f"there are no credentials for {TITLE}; {SERVICES['aws'][2]}")


def session(region: str | None) -> Any:
    """Return an ``AwsSession`` from boto3's own files and variables.

    Parameters
    ----------
    region
        Of the device; ``None``: where it has none, the user's own.

    Raises
    ------
    CredentialsError
        When there are no credentials, or there is no region.
    """
    check_credentials()
    own = _sdk("boto3").Session(region_name=region or None)
    if not own.region_name:
        raise CredentialsError(
            f"there is no region for {TITLE}; set AWS_DEFAULT_REGION, or run 'aws configure'"
        )
    return _sdk("braket.aws").AwsSession(boto_session=own)


def open_device(
    arn: str,
    options: dict[str, Any] | None = None,
    *,
    backoff: Backoff | None = None,
    stop: Callable[[], bool] | None = None,
) -> Any:
    """Return an ``AwsDevice`` that takes tasks.

    Parameters
    ----------
    arn
        Of the device.
    options
        For ``AwsDevice``, such as ``aws_session``.
    backoff, stop
        Of the calls.

    Raises
    ------
    CredentialsError
        When there are no credentials or region, or they are refused.
    RemoteError
        When the service cannot be reached or does not know the device.
    BackendError
        When the device is offline.
    """

    def opening() -> Any:
        given = dict(options or {})
        if given.get("aws_session") is None:
            given["aws_session"] = session(arn.split(":")[3])
        _hide(given["aws_session"])
        return _sdk("braket.aws").AwsDevice(arn, **given)

    device = with_retries(opening, what=TITLE, backoff=backoff, stop=stop)
    check_status(device)
    return device


def check_status(device: Any) -> None:
    """Refuse a device that takes no tasks now.

    Raises
    ------
    BackendError
        When its status is another than ``ONLINE``.
    """
    status = str(getattr(device, "status", "ONLINE"))
    if status != "ONLINE":
        raise BackendError(
            f"device {device.name} ({device.arn}) is {status} and takes no tasks; try again later,"
            " or use another one"
        )


def properties_of(device: Any) -> Any:
    """Return what a device tells of itself, or ``None``."""
    # The SDK's property warns of what it could not read; the private name is what it holds.
    known = getattr(device, "_properties", None)
    return known if known is not None or hasattr(device, "_properties") else device.properties


LOGGERS = ("backoff", "braket.aws.aws_quantum_task")
"""They tell errors and reasons of failures in full, at levels that are shown by default."""


def _sdk(module: str) -> Any:
    mask_logs(*LOGGERS)
    return load(module, TITLE)


def _hide(given: Any) -> None:
    """Remember the secrets of a session, so that no text shows them."""
    ask = getattr(getattr(given, "boto_session", None), "get_credentials", None)
    found = ask() if callable(ask) else None
    if found is not None:
        frozen = found.get_frozen_credentials()
        for value in (frozen.access_key, frozen.secret_key, frozen.token):
            register_secret(value)
