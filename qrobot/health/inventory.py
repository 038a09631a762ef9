"""What this machine has: versions, extras, credentials (present or not), folders to write to."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from pathlib import Path
from typing import Any

from qrobot._extras import distribution_version, extras, install_command
from qrobot._files import can_take_files
from qrobot._version import __version__
from qrobot.jobs.credentials import SERVICES, presence
from qrobot.jobs.store import default_path

__all__ = ["EXTRAS", "inventory", "inventory_text", "packages_of"]

EXTRAS = ("planners", "plot", "qiskit", "ibm", "pennylane", "braket", "docplex", "dwave")
"""The extras that backends need."""


def packages_of(extra: str) -> list[str]:
    """Return what an extra installs beyond the smaller ones that it includes; base: ``""``."""
    held = extras().get(extra, frozenset())
    smaller = [names for other, names in extras().items() if other and names < held]
    return sorted(held.difference(*smaller))


def _folders() -> dict[str, Path]:
    cache = os.environ.get("XDG_CACHE_HOME")
    found = {
        "jobs": default_path().parent,
        "cache": Path(cache) if cache else Path.home() / ".cache",
        "temporary": Path(tempfile.gettempdir()),
        "current": Path.cwd(),
    }
    if numba := os.environ.get("NUMBA_CACHE_DIR"):
        found["numba"] = Path(numba)
    return found


def inventory() -> dict[str, Any]:
    """Return what this machine has, as plain data without any secret.

    Returns
    -------
    dict
        ``python``, ``machine``, ``packages``, ``extras``, ``credentials``, ``folders`` and
        ``problems``: sentences about what hinders qRobot.
    """
    import psutil

    problems = []
    base = {name: distribution_version(name) for name in packages_of("")}
    for name, version in base.items():
        if version is None:
            problems.append(f"{name} is not installed; install it with: pip install qrobot")
    extras = {}
    for extra in EXTRAS:
        versions = {name: distribution_version(name) for name in packages_of(extra)}
        extras[extra] = {
            "installed": None not in versions.values(),
            "packages": versions,
            "install": install_command(extra),
        }
    credentials = {}
    for service, (title, _, advice) in SERVICES.items():
        found = presence(service)
        credentials[service] = {
            "title": title,
            "present": found.present,
            "source": found.source,
            "mend": None if found.present else advice,
        }
        if found.open_to_others:
            problems.append(
                f"the {found.source} with credentials for {title} can be read by others; "
                "run chmod 600 on it"
            )
    folders = {}
    for name, folder in _folders().items():
        folders[name] = {"path": str(folder), "writable": can_take_files(folder)}
        if name in ("jobs", "temporary", "numba") and not folders[name]["writable"]:
            problems.append(f"the {name} folder {folder} cannot be written to")
    return {
        "qrobot": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "machine": {
            "system": f"{platform.system()} {platform.release()}",
            "architecture": platform.machine(),
            "cores": os.cpu_count(),
            "memory_mb": round(psutil.virtual_memory().total / 1e6),
        },
        "packages": base,
        "extras": extras,
        "credentials": credentials,
        "folders": folders,
        "problems": problems,
    }


def inventory_text(data: dict[str, Any]) -> str:
    """Return an inventory as a few plain lines."""
    machine = data["machine"]
    lines = [
        f"qrobot {data['qrobot']}, Python {data['python']} ({data['executable']})",
        f"{machine['system']}, {machine['architecture']}, {machine['cores']} cores, "
        f"{machine['memory_mb']} MB",
        "",
        "packages: " + ", ".join(f"{n} {v or 'ABSENT'}" for n, v in data["packages"].items()),
        "extras:",
    ]
    for extra, about in data["extras"].items():
        have = [f"{name} {version}" for name, version in about["packages"].items() if version]
        lack = [name for name, version in about["packages"].items() if not version]
        text = ", ".join(have)
        if lack:
            text = f"{text + '; ' if have else ''}absent: {', '.join(lack)}: {about['install']}"
        lines.append(f"  {extra:<10} {text}")
    lines.append("credentials (present or not; none is shown):")
    for about in data["credentials"].values():
        where = f"present: {about['source']}" if about["present"] else f"absent; {about['mend']}"
        lines.append(f"  {about['title']:<15} {where}")
    lines.append("folders:")
    for name, about in data["folders"].items():
        state = "writable" if about["writable"] else "NOT writable"
        lines.append(f"  {name:<10} {about['path']}: {state}")
    lines.append("")
    lines += [f"problem: {text}" for text in data["problems"]] or ["no problem was found"]
    return "\n".join(lines)
