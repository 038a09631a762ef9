"""Whether the quantum services can be reached: only when asked, all at once, and never for long.

Each SDK is asked for its own configuration, so that a region or an endpoint that somebody set is
the one that is tried; in a process of its own (``python -m qrobot.health.system.network
SERVICE``), because it is slow and may die.
"""

from __future__ import annotations

import http.client
import importlib
import queue
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

from qrobot._extras import is_installed
from qrobot._processes import child_environment, python_command
from qrobot.health.model import Finding

__all__ = ["SERVICES", "network_findings", "reach"]


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
    parts = urlsplit(SERVICES[service][2]())
    port = f":{parts.port}" if parts.port else ""
    return f"{parts.scheme}://{parts.hostname}{port}/"


ANSWER, TELL = 5.0, 60.0
"""Seconds that a service has to answer, and an SDK to tell where it would turn to."""


def network_findings(answer: float = ANSWER) -> list[Finding]:
    """Return one finding for every service; none takes longer than its two limits."""
    found: queue.SimpleQueue[Finding] = queue.SimpleQueue()
    for service in SERVICES:
        # Daemons: a name server that does not answer holds a thread for minutes.
        threading.Thread(
            target=lambda name: found.put(_finding(name, answer)), args=(service,), daemon=True
        ).start()
    until = time.monotonic() + TELL + 2 * answer
    known: dict[str, Finding] = {}
    with suppress(queue.Empty):
        while len(known) < len(SERVICES):
            finding = found.get(timeout=max(0.0, until - time.monotonic()))
            known[finding.name] = finding
    late = "gave no answer in time; check the network"
    return [
        known.get(_name(service)) or Finding(_name(service), title, "warning", None, late)
        for service, (title, _, _) in SERVICES.items()
    ]


def _name(service: str) -> str:
    return f"endpoint-{service}"


def _finding(service: str, seconds: float) -> Finding:
    title, module, _ = SERVICES[service]
    about = (_name(service), title)
    if not is_installed(module):
        return Finding(*about, "unknown", None, "its SDK is not installed", steady=False)
    url = _address(service)
    if not url:
        text = "its SDK does not tell where it would turn to"
        return Finding(*about, "unknown", None, text, steady=False)
    trouble = reach(url, seconds)
    if trouble:
        text = f"{url} {trouble}; check the network and the proxy"
        return Finding(*about, "warning", False, text, steady=False)
    return Finding(*about, "good", True, f"{url} answers", steady=False)


def _address(service: str) -> str:
    with suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(
            python_command("qrobot.health.system.network", service),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TELL,
            check=True,
            env=child_environment() | {"PYTHONWARNINGS": "ignore"},
        )
        return (done.stdout.strip().splitlines() or [""])[-1]
    return ""


def reach(url: str, seconds: float = ANSWER) -> str:
    """Say why an address gave no answer, or ``""`` when it gave one, be it a refusal.

    Parameters
    ----------
    url
        Asked with HEAD, through the proxy of the environment, its certificate verified.
    seconds
        Seconds for the connection and for each part of the answer.
    """
    try:
        request = urllib.request.Request(url, method="HEAD")  # noqa: S310 (http for our tests)
        with urllib.request.urlopen(request, timeout=seconds):  # noqa: S310
            return ""
    except urllib.error.HTTPError as refusal:
        refusal.close()
        return "" if refusal.code != 407 else "is behind a proxy that refuses us"
    except TimeoutError:
        return f"gave no answer in {seconds:g} s"
    except urllib.error.URLError as error:
        if isinstance(error.reason, TimeoutError):
            return f"gave no answer in {seconds:g} s"
        why = getattr(error.reason, "strerror", None) or type(error.reason).__name__
        return f"cannot be reached ({why})"
    except (OSError, ValueError, http.client.HTTPException) as error:
        return f"gave no sound answer ({type(error).__name__})"


if __name__ == "__main__":
    sys.stdout.write(f"\n{address(sys.argv[1])}\n")
