"""Braket's managed devices: by name, what became of the retired ones, and the way to one.

The names are checked against `braket.devices.Devices` of amazon-braket-sdk 1.127 by a test.
"""

from __future__ import annotations

import re
from typing import Any

from qrobot._extras import load
from qrobot.errors import BackendError, CredentialsError, InputError
from qrobot.jobs import JobOptions
from qrobot.jobs.credentials import SERVICES, presence
from qrobot.jobs.redaction import mask_logs, register_secret
from qrobot.jobs.retry import with_retries

__all__ = [
    "DEVICES",
    "RETIRED",
    "TITLE",
    "arn_of",
    "check_credentials",
    "check_status",
    "open_device",
    "properties_of",
    "session",
]


_SIMULATOR = "arn:aws:braket:::device/quantum-simulator/amazon/"

DEVICES = {
    "SV1": f"{_SIMULATOR}sv1",
    "DM1": f"{_SIMULATOR}dm1",
    "Forte-1": "arn:aws:braket:us-east-1::device/qpu/ionq/Forte-1",
    "Forte-Enterprise-1": "arn:aws:braket:us-east-1::device/qpu/ionq/Forte-Enterprise-1",
    "Garnet": "arn:aws:braket:eu-north-1::device/qpu/iqm/Garnet",
    "Emerald": "arn:aws:braket:eu-north-1::device/qpu/iqm/Emerald",
    "IBEX-Q1": "arn:aws:braket:eu-north-1::device/qpu/aqt/Ibex-Q1",
    "Cepheus-1-108Q": "arn:aws:braket:us-west-1::device/qpu/rigetti/Cepheus-1-108Q",
}

ALIASES = {"ionq": "Forte-1", "iqm": "Emerald", "rigetti": "Cepheus-1-108Q", "forte": "Forte-1"}

RETIRED = {
    "tn1": "SV1",
    "aspen": "Cepheus-1-108Q",
    "ankaa": "Cepheus-1-108Q",
    "harmony": "Forte-1",
    "aria": "Forte-1",
    "lucy": "Garnet",
    "borealis": "Emerald",
}
"""How the last part of a retired device's ARN begins, and its successor."""


def arn_of(device: str) -> str:
    """Return the ARN of a managed device.

    Parameters
    ----------
    device
        An ARN, or a name of `DEVICES` or `ALIASES` in any case.

    Raises
    ------
    BackendError
        When the device was retired; names its successor.
    InputError
        When no gate device has that name.
    """
    last = device.rsplit("/", 1)[-1].lower()
    for start, successor in RETIRED.items():
        if re.match(rf"{start}(?![a-z])", last):
            raise BackendError(
                f"device {device} was retired from Amazon Braket; use {successor} "
                f"({DEVICES[successor]})"
            )
    if last.startswith(("advantage", "dw_2000q")):
        raise BackendError(
            f"device {device} left Amazon Braket in 2022; reach D-Wave by Leap (backend dwave)"
        )
    if last.startswith("aquila"):
        raise BackendError(
            f"device {device} is analog and runs no circuits; use {', '.join(DEVICES)}"
        )
    if device.startswith("arn:"):
        if not re.fullmatch(r"arn:aws[\w-]*:braket:[\w-]*::device/[\w-]+/[\w-]+/[\w.-]+", device):
            raise InputError(
                f"{device!r} is not the ARN of a Braket device",
                field="device",
                advice="an example: " + DEVICES["SV1"],
            )
        return device
    names = {name.lower(): arn for name, arn in DEVICES.items()}
    names |= {alias: DEVICES[name] for alias, name in ALIASES.items()}
    if device.lower() not in names:
        raise InputError(
            f"{device!r} is not a Braket device",
            field="device",
            advice=f"use local, an ARN, or one of {', '.join(DEVICES)}",
        )
    return names[device.lower()]


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


def open_device(arn: str, options: dict[str, Any], limits: JobOptions) -> Any:
    """Return an ``AwsDevice`` that takes tasks.

    Parameters
    ----------
    arn
        Of the device.
    options
        For ``AwsDevice``, such as ``aws_session``.
    limits
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
        given = dict(options)
        if given.get("aws_session") is None:
            given["aws_session"] = session(arn.split(":")[3])
        _hide(given["aws_session"])
        return _sdk("braket.aws").AwsDevice(arn, **given)

    device = with_retries(
        opening, what=TITLE, backoff=limits.backoff, stop=limits.interrupt_function
    )
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
