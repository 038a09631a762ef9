"""What people read while rows run, and at the end."""

from __future__ import annotations

from typing import Any

from qrobot._text import columns
from qrobot.study.reproduce.outcome import Line

__all__ = ["figure_text", "line_text", "place_text", "summary"]


def place_text(line: Line) -> str:
    """Return where in the tables a line is."""
    return f"table {line.table}, n = {line.items}, {line.qubits} qubits, {line.method}"


def line_text(line: Line) -> str:
    """Return a line of a table as a line of progress."""
    start = f"{place_text(line)}: "
    if line.status != "done":
        return f"{start}- ({line.reason})"
    best = "no feasible read" if line.best is None else f"best {line.best:g}"
    return (
        f"{start}{line.seconds:.2f} s, {best} of optimum {line.optimum:g}, "
        f"{line.share:.3g} of {line.reads} reads optimal"
    )


def figure_text(figure: dict[str, Any]) -> str:
    """Return a figure as a line of progress."""
    panels = ", ".join(
        f"{p['distance']:.2f} with {p['robots_used']} at M = {p['capacity']}"
        for p in figure["panels"]
    )
    return f"{figure['figure']}, metres with so many robots, all proven: {panels}"


def summary(report: dict[str, Any], folder: str) -> str:
    """Return the report as a table of text, and where the files are."""
    rows = [
        [
            str(line["table"]), str(line["items"]), str(line["qubits"]), line["method"],
            _text(line["paper_annealer_seconds"]), _text(line["paper_ibmq_seconds"]),
            _text(line["paper_pennylane_seconds"]),
            _text(line["run_seconds" if line["table"] == 3 else "seconds"]),
            _text(line["share"]), _text(line["control_probability"]), _text(line["gap"]),
        ]
        for line in report["lines"]
    ]  # fmt: skip
    heads = [
        "table", "n", "qubits", "method", "paper: annealer", "Qiskit", "PennyLane", "ours, s",
        "optimal reads", "random", "gap",
    ]  # fmt: skip
    parts = [columns(heads, rows, numbers=frozenset(range(11)) - {3})] if rows else []
    parts += [figure_text(figure) + "\n" + figure["note"] for figure in report["figures"]]
    parts += [report["places"], *report["notes"], f"Written to {folder}."]
    return "\n\n".join(parts)


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
