"""Which of many reports is of which machine, and which of them counts."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from datetime import datetime

from qrobot.health.model import Report

__all__ = ["newest"]


def newest(reports: Sequence[Report]) -> tuple[dict[str, Report], list[str]]:
    """Return the newest report of every machine, and what there is to say about it.

    A machine is its name and its id. Where it has no id, its architecture and board stand in for
    it, and it is said that they may be those of several machines.

    Returns
    -------
    machines
        Name to report, in the sequence of the names; no two machines share one.
    notes
        One sentence each.
    """
    found: dict[tuple[str, str], Report] = {}
    many: Counter[tuple[str, str]] = Counter()
    for report in reports:
        key = (report.host, _identity(report))
        many[key] += 1
        if key not in found or _time_of(report) >= _time_of(found[key]):
            found[key] = report
    notes = []
    for key, times in many.items():
        if times > 1:
            notes.append(f"{key[0]}: {times} reports, the newest ({found[key].made}) counts")
            if not found[key].machine_id:
                notes.append(
                    f"{key[0]} has no machine id: reports of several machines of this name cannot "
                    "be told apart"
                )
    hosts = Counter(host for host, _ in found)
    for host, so_many in hosts.items():
        if so_many > 1:
            notes.append(f"{host}: {so_many} machines have this name; give each its own")
    named: dict[str, Report] = {}
    for (host, identity), report in found.items():
        short = identity[:6] if report.machine_id else identity
        name = host if hosts[host] == 1 else f"{host} ({short})"
        if name in named:  # ids that begin alike
            name = f"{host} ({identity})"
        named[name] = report
    return {name: named[name] for name in sorted(named, key=_natural)}, notes


def _identity(report: Report) -> str:
    if report.machine_id:
        return report.machine_id
    return ", ".join(filter(None, ("no id", report.machine, report.model)))


def _time_of(report: Report) -> datetime:
    return datetime.fromisoformat(report.made)


def _natural(name: str) -> list[tuple[int, str]]:
    """Return a key that sorts pi-9 before pi-10; numbers of any length are compared as text."""
    parts = re.split(r"([0-9]+)", name)
    parts[1::2] = [digits.lstrip("0") for digits in parts[1::2]]
    return [(len(part) if k % 2 else -1, part) for k, part in enumerate(parts)]
