"""The faces of a benchmark report: CSV, Markdown, plot."""

from __future__ import annotations

import csv
import io
import math
import os
import re
import statistics
from collections.abc import Sequence
from typing import Any

from qrobot._files import write_text_atomic
from qrobot._numbers import number
from qrobot.report.picture import save, style

__all__ = ["bench_csv", "bench_markdown", "bench_plot", "summaries"]

COLUMNS = (
    "instance", "backend", "seed", "cost", "bound", "reference", "gap", "proven", "feasible",
    "seconds", "peak_mb", "trips", "robots", "wall_seconds", "error",
)  # fmt: skip
EXACT = 1e-9
"""Relative: a cost this close to the reference matches it."""


def bench_csv(report: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Write the rows as CSV."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(report["rows"])
    write_text_atomic(path, text.getvalue())


def summaries(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return one line a backend: how many, how good, how fast.

    Where the names tell several sets (the letters that ``A-n32-k5`` begins with), a line
    for each set follows.
    """
    backends = list(dict.fromkeys(row["backend"] for row in rows))
    sets = list(dict.fromkeys(_set(row) for row in rows))
    lines = [_summary([r for r in rows if r["backend"] == b], b, None) for b in backends]
    if len(sets) > 1 and None not in sets:
        for part in sets:
            for b in backends:
                own = [r for r in rows if r["backend"] == b and _set(r) == part]
                lines += [_summary(own, b, part)] if own else []
    return lines


def _set(row: dict[str, Any]) -> str | None:
    found = re.match(r"([A-Za-z]+)-n\d", row["instance"])
    return found[1] if found else None


def _summary(rows: Sequence[dict[str, Any]], backend: str, part: str | None) -> dict[str, Any]:
    gaps = [row["gap"] for row in rows if row["gap"] is not None]
    seconds = [row["seconds"] for row in rows if row["seconds"] is not None]
    peaks = [row["peak_mb"] for row in rows if row["peak_mb"] is not None]
    return {
        "backend": backend,
        "set": part,
        "runs": len(rows),
        "feasible": sum(row["feasible"] for row in rows),
        "proven": sum(row["proven"] for row in rows),
        "referenced": len(gaps),
        "matched": sum(gap <= EXACT for gap in gaps),
        "mean_gap": statistics.fmean(gaps) if gaps else None,
        "worst_gap": max(gaps, default=None),
        "median_seconds": statistics.median(seconds) if seconds else None,
        "worst_seconds": max(seconds, default=None),
        "worst_peak_mb": max(peaks, default=None),
    }


def bench_markdown(report: dict[str, Any], title: str, *, rows: bool = True) -> str:
    """Return the report as Markdown: the machine, a line a backend, and all rows."""
    host = report["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in host["packages"].items())
    lines = [
        f"## {title}",
        "",
        f"{host['processor']}, {host['cores']} cores, {host['memory_gb']} GB; Python "
        f"{host['python']}; qrobot {host['qrobot']}, {packages}; {report['started'][:10]}. "
        "Seconds are `solve`'s own (imports and reading not included); memory is the whole "
        "process.",
        "",
        "| backend | runs | plans | proven | at the reference | mean gap | worst gap "
        "| median s | worst s | peak MB |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    lines += [
        f"| {s['backend']}{', set ' + s['set'] if s['set'] else ''} | {s['runs']} "
        f"| {s['feasible']} | {s['proven']} "
        f"| {s['matched']} of {s['referenced']} | {_percent(s['mean_gap'])} "
        f"| {_percent(s['worst_gap'])} | {_number(s['median_seconds'])} "
        f"| {_number(s['worst_seconds'])} | {_number(s['worst_peak_mb'], 0)} |"
        for s in summaries(report["rows"])
    ]
    if rows:
        lines += [
            "",
            "| instance | backend | seed | cost | bound | reference | gap | proven | s |",
            "|---|---|--:|--:|--:|--:|--:|---|--:|",
        ]
        lines += [
            f"| {r['instance']} | {r['backend']} | {r['seed']} | {_number(r['cost'])} "
            f"| {_number(r['bound'])} | {_number(r['reference'])} | {_percent(r['gap'])} "
            f"| {'yes' if r['proven'] else r['error'] or 'no'} | {_number(r['seconds'])} |"
            for r in report["rows"]
        ]
    return "\n".join(lines) + "\n"


def bench_plot(report: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Draw the gap to the reference (or the cost) against the seconds, a mark a run.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 4.5), layout="constrained")
        axes = figure.add_subplot()
        found = [row for row in report["rows"] if row["cost"] is not None]
        with_gap = any(row["gap"] is not None for row in found)
        for marker, backend in zip(
            "osD^vPX*" * 9, dict.fromkeys(row["backend"] for row in found), strict=False
        ):
            own = [row for row in found if row["backend"] == backend]
            if with_gap:
                own = [row for row in own if row["gap"] is not None]
            axes.plot(
                [max(row["seconds"], 1e-3) for row in own],
                [100 * row["gap"] if with_gap else row["cost"] for row in own],
                marker,
                label=backend,
                alpha=0.7,
            )
        axes.set_xscale("log")
        axes.set_xlabel("seconds of solve")
        axes.set_ylabel("gap to the reference, %" if with_gap else "distance")
        axes.grid(alpha=0.3)
        if axes.get_lines():
            axes.legend()
        save(figure, path)


def _percent(value: float | None) -> str:
    return "-" if value is None or not math.isfinite(value) else f"{100 * value:.2f} %"


def _number(value: float | None, digits: int = 2) -> str:
    return "-" if value is None or not math.isfinite(value) else number(round(value, digits))
