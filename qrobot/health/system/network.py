"""Whether the services can be reached: only when asked, all at once, and never for long."""

from __future__ import annotations

import http.client
import os
import queue
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import suppress
from pathlib import Path

from qrobot._extras import is_installed
from qrobot.health.model import Finding
from qrobot.health.system.endpoints import SERVICES

__all__ = ["network_findings", "reach"]

ROOT = Path(__file__).resolve().parents[3]
"""The folder that holds qRobot."""

ANSWER, TELL = 5.0, 60.0
"""Seconds that a service has to answer, and an SDK to tell where it would turn to."""


def network_findings(answer: float = ANSWER) -> list[Finding]:
    """Return one finding for every service; none takes longer than its two limits.

    Parameters
    ----------
    answer
        Seconds that a service has to answer.
    """
    found: queue.SimpleQueue[Finding] = queue.SimpleQueue()
    for service in SERVICES:
        # Daemons: a name server that does not answer holds a thread for minutes.
        threading.Thread(
            target=lambda name: found.put(_finding(name, answer)), args=(service,), daemon=True
        ).start()
    until = time.monotonic() + TELL + 2 * answer
    told: dict[str, Finding] = {}
    with suppress(queue.Empty):
        while len(told) < len(SERVICES):
            finding = found.get(timeout=max(0.0, until - time.monotonic()))
            told[finding.name] = finding
    late = "gave no answer in time; check the network"
    return [
        told.get(_name(service)) or Finding(_name(service), title, "warning", None, late)
        for service, (title, _, _) in SERVICES.items()
    ]


def _name(service: str) -> str:
    return f"endpoint-{service}"


def _finding(service: str, patience: float) -> Finding:
    title, module, _ = SERVICES[service]
    about = (_name(service), title)
    if not is_installed(module):
        return Finding(*about, "unknown", None, "its SDK is not installed", steady=False)
    url = _address(service)
    if not url:
        text = "its SDK does not tell where it would turn to"
        return Finding(*about, "unknown", None, text, steady=False)
    trouble = reach(url, patience)
    if trouble:
        text = f"{url} {trouble}; check the network and the proxy"
        return Finding(*about, "warning", False, text, steady=False)
    return Finding(*about, "good", True, f"{url} answers", steady=False)


def _address(service: str) -> str:
    command = [sys.executable, "-P", "-W", "ignore", "-m", "qrobot.health.system.endpoints"]
    with suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(
            [*command, service],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TELL,
            check=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join([*filter(None, sys.path), str(ROOT)])},
        )
        return (done.stdout.strip().splitlines() or [""])[-1]
    return ""


def reach(url: str, patience: float = ANSWER) -> str:
    """Say why an address gave no answer, or ``""`` when it gave one, be it a refusal.

    Parameters
    ----------
    url
        Asked with HEAD, through the proxy of the environment, its certificate verified.
    patience
        Seconds for the connection and for each part of the answer.
    """
    try:
        request = urllib.request.Request(url, method="HEAD")  # noqa: S310 (http for our tests)
        with urllib.request.urlopen(request, timeout=patience):  # noqa: S310
            return ""
    except urllib.error.HTTPError as refusal:
        refusal.close()
        return "" if refusal.code != 407 else "is behind a proxy that refuses us"
    except TimeoutError:
        return f"gave no answer in {patience:g} s"
    except urllib.error.URLError as error:
        if isinstance(error.reason, TimeoutError):
            return f"gave no answer in {patience:g} s"
        why = getattr(error.reason, "strerror", None) or type(error.reason).__name__
        return f"cannot be reached ({why})"
    except (OSError, ValueError, http.client.HTTPException) as error:
        return f"gave no sound answer ({type(error).__name__})"
