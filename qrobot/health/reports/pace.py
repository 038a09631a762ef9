"""How fast each machine of a fleet is, held against the median of all."""

from __future__ import annotations

import statistics

from qrobot.health.model import Report
from qrobot.health.reports.facts import seconds

__all__ = ["paces"]

SLOW, SECONDS = 2.0, 0.5
"""A check is named slow from this factor of the fleet's median, and so many seconds above it."""


def paces(
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
            if (took := seconds(check)) is not None and took > 0:
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
