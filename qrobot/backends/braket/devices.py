"""Braket's managed gate devices by name, and what became of the retired ones.

Checked against `braket.devices.Devices` of amazon-braket-sdk 1.127 by a test.
"""

from __future__ import annotations

import re

from qrobot.errors import BackendError, InputError

__all__ = ["DEVICES", "RETIRED", "arn_of"]

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
