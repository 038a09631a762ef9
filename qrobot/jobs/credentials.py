"""Which credentials are there, from the SDKs' own standard files and variables.

Nothing here imports an SDK or asks a network, and nothing here returns a value to a place
that could print it: `presence` tells where a credential lies, never what it is.
"""

from __future__ import annotations

import configparser
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qrobot.errors import CredentialsError

__all__ = ["SERVICES", "Presence", "presence", "require", "secrets_in_files"]

_SECRET_KEYS = ("token", "secret", "password", "key", "headers", "proxy")


@dataclass(frozen=True, slots=True)
class Presence:
    """Whether a service's credentials are there.

    Parameters
    ----------
    present
        Whether something was found; it may still be refused.
    source
        Where, such as ``variable DWAVE_API_TOKEN``; never what.
    advice
        How to provide it.
    open_to_others
        True when the file can be read by other users of this machine.
    """

    present: bool
    source: str
    advice: str
    open_to_others: bool = False


def _expanded(path: str) -> Path:
    """Return a path with its ``~``, which stays where nobody knows a home: pathlib would raise."""
    return Path(os.path.expanduser(path))


def _config_home() -> Path:
    return Path(os.environ.get("XDG_CONFIG_HOME") or _expanded("~/.config"))


def _dwave_files() -> list[Path]:
    named = os.environ.get("DWAVE_CONFIG_FILE")
    if named:
        return [_expanded(named)]
    system = os.environ.get("XDG_CONFIG_DIRS") or "/etc/xdg"
    folders = [Path(), _config_home() / "dwave"]
    folders += [Path(folder) / "dwave" for folder in system.split(":") if folder]
    return [folder / "dwave.conf" for folder in [*folders, Path("/etc/dwave")]]


def _ibm_files() -> list[Path]:
    named = os.environ.get("QISKIT_IBM_CREDENTIALS_FILE")
    return [_expanded(named or "~/.qiskit/qiskit-ibm.json")]


def _aws_files() -> list[Path]:
    return [
        _expanded(os.environ.get("AWS_SHARED_CREDENTIALS_FILE") or "~/.aws/credentials"),
        _expanded(os.environ.get("AWS_CONFIG_FILE") or "~/.aws/config"),
    ]


SERVICES: dict[str, tuple[str, tuple[str, ...], str]] = {
    # service: (what it is, variables that hold the secret, how to provide it)
    "dwave": (
        "D-Wave Leap",
        ("DWAVE_API_TOKEN",),
        "run 'dwave setup', or set DWAVE_API_TOKEN",
    ),
    "ibm": (
        "IBM Quantum",
        ("QISKIT_IBM_TOKEN",),
        "call QiskitRuntimeService.save_account once, or set QISKIT_IBM_TOKEN"
        " and QISKIT_IBM_INSTANCE",
    ),
    "aws": (
        "Amazon Braket",
        ("AWS_SECRET_ACCESS_KEY",),
        "run 'aws configure', or set AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY"
        " and AWS_DEFAULT_REGION",
    ),
}
_FILES = {"dwave": _dwave_files, "ibm": _ibm_files, "aws": _aws_files}


def _read_ini(path: Path) -> Iterator[tuple[str, str]]:
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    parser.read_string(path.read_text(encoding="utf-8"))
    for section in [parser.default_section, *parser.sections()]:
        yield from parser[section].items()


def _read_json(data: Any) -> Iterator[tuple[str, str]]:
    if isinstance(data, dict):
        for key, value in data.items():
            if isinstance(value, str):
                yield str(key), value
            else:
                yield from _read_json(value)


def _pairs(path: Path) -> list[tuple[str, str]]:
    """Return names and values of a credentials file; nothing when it cannot be read."""
    try:
        if path.suffix == ".json":
            return list(_read_json(json.loads(path.read_text(encoding="utf-8"))))
        return list(_read_ini(path))
    except (OSError, ValueError, configparser.Error):
        return []


def _is_secret(name: str) -> bool:
    return any(part in name.lower() for part in _SECRET_KEYS)


def secrets_in_files() -> Iterator[str]:
    """Yield the secret values of all standard files, for masking and nothing else."""
    for files in _FILES.values():
        for path in files():
            for name, value in _pairs(path):
                if _is_secret(name) and value:
                    yield value


def presence(service: str) -> Presence:
    """Return whether credentials of one of `SERVICES` are there, without any of them."""
    _, variables, advice = SERVICES[service]
    for name in variables:
        if os.environ.get(name):
            return Presence(True, f"variable {name}", advice)
    for path in _FILES[service]():
        if any(_is_secret(name) and value for name, value in _pairs(path)):
            try:
                others = bool(path.stat().st_mode & 0o077)
            except OSError:
                others = False
            return Presence(True, f"file {path}", advice, others)
    if service == "aws":
        for name in (
            "AWS_WEB_IDENTITY_TOKEN_FILE",
            "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
            "AWS_CONTAINER_CREDENTIALS_FULL_URI",
            "AWS_PROFILE",
        ):
            if os.environ.get(name):
                return Presence(True, f"variable {name}", advice)
    return Presence(False, "not found", advice)


def require(service: str) -> Presence:
    """Return where a service's credentials are.

    Raises
    ------
    CredentialsError
        When there are none: at once, without asking a network.
    """
    found = presence(service)
    if not found.present:
        title = SERVICES[service][0]
        raise CredentialsError(f"there are no credentials for {title}; {found.advice}")
    return found
