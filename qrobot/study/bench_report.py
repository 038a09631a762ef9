"""A benchmark report as CSV, Markdown and a plot."""

from __future__ import annotations

import os
import re
import statistics
from collections.abc import Sequence
from typing import Any

from qrobot._numbers import number
from qrobot.study.bench import BenchRow
from qrobot.study.render import (
    figure_text,
    machine_text,
    markdown_table,
    percent,
    plotted,
    write_csv,
)

__all__ = ["bench_csv", "bench_markdown", "bench_plot", "row_text", "summaries"]

COLUMNS = (
    "instance", "backend", "seed", "cost", "bound", "reference", "gap", "proven", "feasible",
    "seconds", "peak_mb", "trips", "robots", "wall_seconds", "error", "reference_status",
)  # fmt: skip
EXACT = 1e-9
"""Relative: a cost this close to the reference matches it."""


def bench_csv(report: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Write the rows as CSV."""
    write_csv(report["rows"], COLUMNS, path)


def summaries(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return one line a backend: how many, how good, how fast.

    Where the names tell several sets (the letters that ``A-n32-k5`` begins with, or folders), a
    line for each set follows.
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
    folder, _, name = row["instance"].rpartition("/")
    found = re.match(r"([A-Za-z]+)-n\d", name)
    return found[1] if found else folder or None


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
    heads = [
        "backend", "runs", "plans", "proven", "at the reference", "mean gap", "worst gap",
        "median s", "worst s", "peak MB",
    ]  # fmt: skip
    cells = [
        [
            s["backend"] + (f", set {s['set']}" if s["set"] else ""),
            *(str(s[name]) for name in ("runs", "feasible", "proven")),
            f"{s['matched']} of {s['referenced']}",
            *(percent(s[name]) for name in ("mean_gap", "worst_gap")),
            *(figure_text(s[name], 2) for name in ("median_seconds", "worst_seconds")),
            figure_text(s["worst_peak_mb"], 0),
        ]
        for s in summaries(report["rows"])
    ]
    lines = [
        f"## {title}",
        "",
        f"{machine_text(report)} Seconds are `solve`'s own (imports and reading not included); "
        f"memory is the whole process.{_objective_text(report)}",
        "",
        *markdown_table(heads, cells, left={0}),
    ]
    if rows:
        heads = ["instance", "backend", "seed", "cost", "bound", "reference", "gap", "proven", "s"]
        cells = [
            [
                *(str(r[name]) for name in ("instance", "backend", "seed")),
                *(figure_text(r[name], 2) for name in ("cost", "bound", "reference")),
                percent(r["gap"]),
                "yes" if r["proven"] else r["error"] or "no",
                figure_text(r["seconds"], 2),
            ]
            for r in report["rows"]
        ]
        lines += ["", *markdown_table(heads, cells, left={0, 1, 7})]
    return "\n".join(lines) + "\n"


def _objective_text(report: dict[str, Any]) -> str:
    objective = report.get("objective", "distance")
    return "" if objective == "distance" else f" Costs are by the objective {objective}."


def row_text(row: BenchRow) -> str:
    """Return a run as a line of progress."""
    gap = "" if row.gap is None else f", gap {row.gap:.2%}"
    found = row.error if row.cost is None else f"{number(row.cost)}{gap}"
    proven = ", proven" if row.proven else ""
    seconds = row.seconds or row.wall_seconds or 0.0
    return f"{row.instance} {row.backend} seed {row.seed}: {found}{proven}, {seconds:.2f} s"


def bench_plot(report: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Draw the gap to the reference (or the cost) against the seconds, a mark a run."""
    found = [row for row in report["rows"] if row["cost"] is not None]
    with_gap = any(row["gap"] is not None for row in found)
    shown = [row for row in found if row["gap"] is not None or not with_gap]
    with plotted(path, (8, 4.5)) as (_, axes):
        for marker, backend in zip(
            "osD^vPX*" * 9, dict.fromkeys(row["backend"] for row in found), strict=False
        ):
            own = [row for row in shown if row["backend"] == backend]
            axes.plot(
                [max(row["seconds"], 1e-3) for row in own],
                [100 * row["gap"] if with_gap else row["cost"] for row in own],
                marker,
                label=backend,
                alpha=0.7,
            )
        axes.set_xscale("log")
        axes.set_xlabel("seconds of solve")
        axes.set_ylabel(
            "gap to the reference, %" if with_gap else report.get("objective", "distance")
        )
        if axes.get_lines():
            axes.legend()
