"""Where the SDKs would turn to: ``python -m qrobot.health.system.endpoints SERVICE``.

Each SDK is asked for its own configuration, so that a region or an endpoint that somebody set
is the one that is tried; in a process of its own, because it is slow and may die. No network
is used here.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any

__all__ = ["SERVICES", "address"]


def _braket() -> str:
    session: Any = importlib.import_module("botocore.session").Session()
    region = session.get_config_variable("region") or "us-east-1"
    return str(session.create_client("braket", region_name=region).meta.endpoint_url)


def _ibm() -> str:
    accounts: Any = importlib.import_module("qiskit_ibm_runtime.accounts")
    try:
        url = accounts.AccountManager.get(channel="ibm_quantum_platform").url
    except accounts.AccountNotFoundError:
        url = None
    default = importlib.import_module("qiskit_ibm_runtime.accounts.account")
    return str(url or default.IBM_QUANTUM_PLATFORM_API_URL)


def _leap() -> str:
    config: Any = importlib.import_module("dwave.cloud.config")
    default = importlib.import_module("dwave.cloud.config.constants").DEFAULT_SOLVER_API_ENDPOINT
    return str(config.load_config().get("endpoint") or default)


SERVICES: dict[str, tuple[str, str, Callable[[], str]]] = {
    "braket": ("Amazon Braket", "botocore", _braket),
    "ibm": ("IBM Quantum", "qiskit_ibm_runtime", _ibm),
    "leap": ("D-Wave Leap", "dwave.cloud", _leap),
}
"""Title, the module that is asked, and how."""


def address(service: str) -> str:
    """Return scheme, host and port of a service, without path, user or password."""
    from urllib.parse import urlsplit

    parts = urlsplit(SERVICES[service][2]())
    port = f":{parts.port}" if parts.port else ""
    return f"{parts.scheme}://{parts.hostname}{port}/"


if __name__ == "__main__":
    sys.stdout.write(f"\n{address(sys.argv[1])}\n")
