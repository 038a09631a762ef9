"""The faces of reproduced tables: CSV, Markdown; plots are made beside."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from qrobot._files import write_text_atomic
from qrobot._numbers import number
from qrobot.errors import MissingExtraError
from qrobot.study.reproduce.methods import ANNEALERS, METHODS, VQES
from qrobot.study.reproduce.outcome import Line
from qrobot.study.reproduce.paper import DEVICES, TITLE, YEAR, paper_rows
from qrobot.study.reproduce.plots import table_plot

__all__ = ["COLUMNS", "table_csv", "table_markdown", "write_tables"]

Rows = Sequence[dict[str, Any]]

COLUMNS = tuple(f.name for f in fields(Line) if f.name != "details")

INCLUDED = (
    "building the model (or listing or counting the plans), searching parameters and sampling; "
    "imports, compilation and decoding are left out"
)
SUMMARY = {
    1: f"Seconds are everything: {INCLUDED}.",
    2: f"Seconds are everything: {INCLUDED}. The paper's include waiting and queue.",
    3: "Seconds are the sampling alone (one run of the circuit and its shots, or the annealer's "
    "reads), from the same runs as table 2: no model, no search for parameters, no decoding. "
    "The paper prints the gate columns of table 2 once more.",
}


def write_tables(report: dict[str, Any], folder: Path, plots: bool) -> list[str]:
    """Write CSV, Markdown and, when asked, plots of each table; return notes."""
    notes = []
    for table in sorted({line["table"] for line in report["lines"]}):
        own = [line for line in report["lines"] if line["table"] == table]
        table_csv(own, folder / f"table{table}.csv")
        write_text_atomic(folder / f"table{table}.md", table_markdown(report, table))
        if plots:
            try:
                for suffix in ("svg", "png"):
                    table_plot(own, table, folder / f"table{table}.{suffix}")
            except MissingExtraError as error:
                notes.append(f"plots are left out: {error}")
    return notes


def table_csv(rows: Rows, path: Path) -> None:
    """Write the lines of a table as CSV, one a method."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text_atomic(path, text.getvalue())


def table_markdown(report: dict[str, Any], table: int) -> str:
    """Return a table as Markdown: the paper's seconds beside ours, then what was found."""
    rows = [line for line in report["lines"] if line["table"] == table]
    host, settings = report["machine"], report["settings"]
    installed = host["packages"]
    packages = ", ".join(f"{name} {version}" for name, version in installed.items())
    lines = [
        f"### The paper's table {table}",
        "",
        f"Rows (n, K = 1, M, qubits) as in table {table} of “{TITLE}” ({YEAR}); its seconds stand "
        f"beside ours. {report['places']} The penalty form is the `{_encoding(table)}` encoding "
        "with the paper's slack.",
        "",
        f"Ours: {host['processor']}, {host['cores']} cores, {host['memory_gb']} GB; Python "
        f"{host['python']}; qrobot {host['qrobot']}, {packages}; {report['started'][:10]}. "
        f"{settings['reads']} reads, seed {settings['seed']}. {SUMMARY[table]} From n = 10 on "
        "distances are rounded to whole metres, because plans are counted by distance.",
        "",
        *_seconds(rows, table),
        "",
        *_quality(rows),
    ]
    if left := _left(rows):
        lines += ["", "Left empty:", "", *left]
    if report["interrupted"]:
        lines += ["", "This run was interrupted: rows are missing."]
    return "\n".join(lines) + "\n"


def _encoding(table: int) -> str:
    return paper_rows(table)[0].encoding


def _seconds(rows: Rows, table: int) -> list[str]:
    """Return the table in the paper's shape."""
    part = "run_seconds" if table == 3 else "seconds"
    methods = [name for name in METHODS if any(row["method"] == name for row in rows)]
    annealers = [name for name in methods if name in ANNEALERS]
    gates = [name for name in methods if name not in ANNEALERS]
    heads = ["n", "M", "qubits", "paper: annealer"]
    heads += [f"`{name}`" for name in annealers]
    heads += ["paper: Qiskit simulator", "paper: PennyLane"]
    heads += [f"`{name}`" if name in VQES else METHODS[name].label for name in gates]
    found = []
    for n in dict.fromkeys(row["items"] for row in rows):
        own = {row["method"]: row for row in rows if row["items"] == n}
        one = next(iter(own.values()))
        cells = [str(n), str(one["capacity"]), str(one["qubits"])]
        cells.append(_time(one["paper_annealer_seconds"]))
        cells += [_time(own.get(name, {}).get(part)) for name in annealers]
        cells += [_time(one["paper_ibmq_seconds"]), _time(one["paper_pennylane_seconds"])]
        cells += [_time(own.get(name, {}).get(part)) for name in gates]
        found.append(cells)
    named = {column: DEVICES[column] for row in paper_rows(table) for column in row.seconds}
    told = "; ".join(dict.fromkeys(named.values()))
    return [*_table(heads, found, 0), "", f"The paper's columns: {told}."]


def _quality(rows: Rows) -> list[str]:
    heads = [
        "n", "qubits", "method", "states", "s", "feasible reads", "optimal reads", "P(optimum)",
        "random: P", "gain", "best", "gap", "random: best", "optimum", "random plans: P", "gain",
        "best",
    ]  # fmt: skip
    found = []
    for row in rows:
        if row["status"] != "done":
            continue
        p = row["share"] if row["probability"] is None else row["probability"]
        random = row["control_probability"]
        found.append(
            [
                str(row["items"]),
                str(row["qubits"]),
                f"`{row['method']}`",
                "-" if row["states"] is None else f"{row['states']:,}",
                _time(row["seconds"]),
                f"{row['feasible']:.3g}",
                f"{row['share']:.3g}",
                "-" if row["probability"] is None else f"{row['probability']:.2g}",
                f"{random:.2g}{'' if row['control'] == 'plans' else ' *'}",
                _gain(p / random),
                _number(row["best"]),
                "-" if row["gap"] is None else f"{round(100 * row['gap'], 1) + 0.0:.1f} %",
                _number(row["control_best"]),
                _number(row["optimum"]),
                f"{row['plans_probability']:.2g}",
                _gain(p / row["plans_probability"]),
                f"{row['plans_best']:.1f}",
            ]
        )
    return [
        "What each method read by itself: no repair, no polish. P(optimum) is exact where the "
        "state is known; otherwise the share of optimal reads stands for it in the gain. Random, "
        "at as many guesses: uniform bit strings (*), or uniform feasible plans for the mixers "
        "that know only those. The last three columns are uniform feasible plans for every method, "
        "the stricter control: the chance of one, the gain over it, and the expected best of all. "
        "The optimum is proven by the exact planner.",
        "",
        *_table(heads, found, 2),
    ]


def _left(rows: Rows) -> list[str]:
    """Return why cells are empty, one line a reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row["status"] != "done":
            key = (row["status"], row["reason"] or "no reason was told")
            found.setdefault(key, []).append(f"`{row['method']}` at n = {row['items']}")
    told = [
        f"- {', '.join(who)}: {'failed, ' if status == 'failed' else ''}{reason}."
        for (status, reason), who in found.items()
    ]
    if any(row["items"] > 3 for row in rows):
        told.append(
            "- VQE is run at n = 2 and 3, and the penalty form holds all 2^qubits states: beyond "
            "26 qubits only the mixers that keep the constraints are simulated, which know the n! "
            "plans alone."
        )
    return told


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]], text: int) -> list[str]:
    """Return a Markdown table, numbers to the right; column `text` to the left."""
    marks = ["---" if k == text and text else "--:" for k in range(len(heads))]
    return [f"| {' | '.join(row)} |" for row in (heads, marks, *rows)]


def _time(seconds: float | None) -> str:
    if seconds is None:
        return "-"
    if seconds >= 10:
        return f"{seconds:.0f}" if seconds >= 100 else f"{seconds:.1f}"
    return f"{seconds:.2f}" if seconds >= 0.1 else f"{seconds:.2g}"


def _gain(value: float) -> str:
    if value >= 1e5:
        return f"{value:.1e}"
    return f"{value:,.0f}" if value >= 10 else f"{value:.2g}"


def _number(value: float | None) -> str:
    return "-" if value is None else number(value)
