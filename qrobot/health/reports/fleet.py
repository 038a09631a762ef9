"""Many reports, one a machine: in what they differ, and from whom."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Any

from qrobot._text import Table, count
from qrobot.health.model import Report
from qrobot.health.reports.summary import facts, totals_line, when

__all__ = ["Column", "FleetHealth", "fleet"]

SLOW, SECONDS = 2.0, 0.5
"""A check is named slow from this factor of the fleet's median, and so many seconds above it."""

NOT_ASKED = None
"""The value of a machine on which this was not looked at."""


@dataclass(frozen=True)
class Column:
    """One thing that is not the same everywhere.

    Parameters
    ----------
    kind, name
        ``machine``, ``status`` or ``version``, and of what.
    values
        Machine to value; ``-`` where there is none, None where it was not looked at.
    """

    kind: str
    name: str
    values: dict[str, str | None]

    @cached_property
    def majority(self) -> str | None:
        """The value of most machines, None when no value leads."""
        counts = Counter(value for value in self.values.values() if value is not NOT_ASKED)
        (first, most), *others = counts.most_common(2)
        return None if others and others[0][1] == most else first

    @property
    def different(self) -> dict[str, list[str]]:
        """Value to the machines that have it, without the majority's."""
        found: dict[str, list[str]] = {}
        for machine, value in self.values.items():
            if value is not NOT_ASKED and value != self.majority:
                found.setdefault(value, []).append(machine)
        return found

    def differs(self, machine: str) -> bool:
        """Return whether a machine is not with the majority, where there is one."""
        return self.majority is not None and self.values[machine] not in (NOT_ASKED, self.majority)

    def sentence(self) -> str:
        """Return the majority and who differs from it."""
        others = [f"{value} on {', '.join(names)}" for value, names in self.different.items()]
        if self.majority is None:
            return f"{self.kind} {self.name}: no majority; {'; '.join(others)}"
        most = sum(value == self.majority for value in self.values.values())
        return f"{self.kind} {self.name}: {self.majority} on {most}; {'; '.join(others)}"


@dataclass(frozen=True)
class FleetHealth:
    """The machines and their differences.

    Parameters
    ----------
    machines
        Name to report, in the sequence of their names.
    columns
        What differs.
    pace
        Machine to its time over the fleet's median: the median of all checks that passed on
        it and on another one; None without such a check.
    slow
        Machine to its slow checks with the factor.
    notes
        What was left out, and why.
    """

    machines: dict[str, Report]
    columns: tuple[Column, ...]
    pace: dict[str, float | None]
    slow: dict[str, dict[str, float]]
    notes: tuple[str, ...]

    @property
    def unhealthy(self) -> list[str]:
        """The machines with a bad check or a fault."""
        return [name for name, report in self.machines.items() if not report.healthy]

    def differences(self, machine: str) -> int:
        """Return in how many columns a machine is not with the majority."""
        return sum(column.differs(machine) for column in self.columns)

    def table(self, columns: Sequence[Column] | None = None) -> Table:
        """Return one row a machine; the columns are what differs."""
        chosen = self.columns if columns is None else columns
        rows = [
            (
                name,
                "healthy" if report.healthy else "unhealthy",
                when(report),
                "-" if (pace := self.pace[name]) is None else f"{pace:.2f}",
                str(self.differences(name)),
                *("?" if column.values[name] is None else str(column.values[name])
                  for column in chosen),
            )
            for name, report in self.machines.items()
        ]  # fmt: skip
        heads = ("machine", "state", "made (UTC)", "time / median", "differs")
        return Table(
            "Machines",
            (*heads, *(f"{column.name}" for column in chosen)),
            tuple(rows),
            frozenset({3, 4}),
            1,
            frozenset(
                (row, len(heads) + place)
                for row, name in enumerate(self.machines)
                for place, column in enumerate(chosen)
                if column.differs(name)
            ),
        )

    def headline(self) -> str:
        """Return how many machines there are, how many are unhealthy, and what differs."""
        machines, columns = len(self.machines), len(self.columns)
        return (
            f"{count(machines, 'machine')}, {len(self.unhealthy)} unhealthy, "
            f"{count(columns, 'difference')}"
        )

    def bad_lines(self) -> list[str]:
        """Return the unhealthy machines with what is wrong, one sentence each."""
        lines = []
        for name in self.unhealthy:
            report = self.machines[name]
            why = [f"{check.name} {check.status}: {check.message}" for check in report.bad]
            why += [f"{finding.title}: {finding.message}" for finding in report.faults]
            lines.append(f"{name} is unhealthy: {'; '.join(why)}")
        return lines

    def slow_lines(self) -> list[str]:
        """Return the machines with slow checks, one sentence each."""
        return [
            f"{name} is slow: "
            + ", ".join(f"{check} {factor:.1f} × the median" for check, factor in found.items())
            for name, found in self.slow.items()
            if found
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "schema": "qrobot.health.fleet/1",
            "notes": list(self.notes),
            "machines": [
                {
                    "name": name,
                    "host": report.host,
                    "machine_id": report.machine_id,
                    "made": report.made,
                    "healthy": report.healthy,
                    "totals": report.totals,
                    "said": totals_line(report),
                    "time_factor": self.pace[name],
                    "slow": self.slow[name],
                    "differs": self.differences(name),
                }
                for name, report in self.machines.items()
            ],
            "differences": [
                {
                    "kind": column.kind,
                    "name": column.name,
                    "majority": column.majority,
                    "different": column.different,
                    "values": column.values,
                }
                for column in self.columns
            ],
        }


def fleet(reports: Sequence[Report]) -> FleetHealth:
    """Return the view of many machines; of several reports of one machine the newest counts."""
    machines, notes = _newest(reports)
    pace, slow = _paces(machines)
    return FleetHealth(machines, tuple(_columns(machines)), pace, slow, tuple(notes))


def _columns(machines: dict[str, Report]) -> list[Column]:
    """Return what is not the same everywhere, statuses first."""
    facts_of = {name: facts(report) for name, report in machines.items()}
    checks = {name: {c.name: c.status for c in r.checks} for name, r in machines.items()}
    states = {name: {f.name: f.status for f in r.system} for name, r in machines.items()}
    packages = {name: _versions(report, machines) for name, report in machines.items()}
    found = []
    for kind, table in (
        ("status", checks), ("status", states), ("machine", facts_of), ("version", packages)
    ):  # fmt: skip
        names = dict.fromkeys(key for row in table.values() for key in row)
        for key in names:
            values: dict[str, str | None] = {
                name: row.get(key, NOT_ASKED) for name, row in table.items()
            }
            if len({value for value in values.values() if value is not NOT_ASKED}) > 1:
                found.append(Column(kind, key, values))
    return found


def _versions(report: Report, machines: dict[str, Report]) -> dict[str, str]:
    """Return the versions of a machine, ``-`` for packages that a check looked for in vain."""
    looked = {check.name for check in report.checks}
    found = {"qrobot": report.qrobot}
    for other in machines.values():
        for check in other.checks:
            if check.name in looked:
                found |= dict.fromkeys(check.versions.keys() - found.keys(), "-")
    return found | report.versions


def _newest(reports: Sequence[Report]) -> tuple[dict[str, Report], list[str]]:
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
        if key not in found or _made(report) >= _made(found[key]):
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


def _made(report: Report) -> datetime:
    return datetime.fromisoformat(report.made)


def _natural(name: str) -> list[tuple[int, str]]:
    """Return a key that sorts pi-9 before pi-10; numbers of any length are compared as text."""
    parts = re.split(r"([0-9]+)", name)
    parts[1::2] = [digits.lstrip("0") for digits in parts[1::2]]
    return [(len(part) if k % 2 else -1, part) for k, part in enumerate(parts)]


def _paces(
    machines: dict[str, Report],
) -> tuple[dict[str, float | None], dict[str, dict[str, float]]]:
    """Return the pace of each machine, and its slow checks.

    Returns
    -------
    pace
        Machine to the median, over its checks, of its time over the fleet's median; None for a
        machine whose checks passed nowhere else.
    slow
        Machine to its slow checks, with the factor.
    """
    times: dict[str, dict[str, float]] = {}
    for name, report in machines.items():
        for check in report.checks:
            if check.status == "pass" and (took := check.seconds):
                times.setdefault(check.name, {})[name] = took
    ratios: dict[str, list[float]] = {name: [] for name in machines}
    slow: dict[str, dict[str, float]] = {name: {} for name in machines}
    for check_name, row in times.items():
        if len(row) < 2:
            continue
        middle = statistics.median(row.values())
        for name, took in row.items():
            ratios[name].append(took / middle)
            if took > SLOW * middle and took - middle > SECONDS:
                slow[name][check_name] = round(took / middle, 2)
    pace = {name: round(statistics.median(r), 3) if r else None for name, r in ratios.items()}
    return pace, slow
