"""Reproduced tables: CSV, Markdown, plots, and what people read while rows run and at the end."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from qrobot._files import read_text, write_text_atomic
from qrobot._text import columns
from qrobot.errors import InputError, MissingExtraError
from qrobot.report.palette import INK, colour_of
from qrobot.study.render import (
    figure_text,
    machine_text,
    markdown_table,
    percent,
    plotted,
    write_csv,
)
from qrobot.study.reproduce.methods import ANNEALERS, METHODS, VQES
from qrobot.study.reproduce.paper import DEVICES, TITLE, YEAR, paper_rows
from qrobot.study.reproduce.question import Outcome

__all__ = [
    "check_page", "drawn_text", "fill_page", "place_text", "result_text", "summary", "write_tables",
]  # fmt: skip

PAPER = (
    ("paper_annealer_seconds", "annealer", "s"),
    ("paper_ibmq_seconds", "Qiskit simulator", "^"),
    ("paper_pennylane_seconds", "PennyLane", "v"),
)
SHAPES = "oDPX*phd>"
LEAST = 1e-5
"""Seconds below which a point stands at the edge."""

Rows = Sequence[dict[str, Any]]

MARKERS = "<!-- reproduce:{0} -->", "<!-- end of {0} -->"
"""Around the place of a table in a page of the documentation."""

COLUMNS = tuple(f.name for f in fields(Outcome) if f.name != "details")

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
        write_csv(own, COLUMNS, folder / f"table{table}.csv")
        write_text_atomic(folder / f"table{table}.md", _markdown(report, table))
        if plots:
            try:
                for suffix in ("svg", "png"):
                    _plot(own, table, folder / f"table{table}.{suffix}")
            except MissingExtraError as error:
                notes.append(f"plots are left out: {error}")
    return notes


def _markdown(report: dict[str, Any], table: int) -> str:
    """Return a table as Markdown: the paper's seconds beside ours, then what was found."""
    rows = [line for line in report["lines"] if line["table"] == table]
    settings, encoding = report["settings"], paper_rows(table)[0].encoding
    lines = [
        f"### The paper's table {table}",
        "",
        f"Rows (n, K = 1, M, qubits) as in table {table} of “{TITLE}” ({YEAR}); its seconds stand "
        f"beside ours. {report['places']} The penalty form is the `{encoding}` encoding "
        "with the paper's slack.",
        "",
        f"Ours: {machine_text(report)} {settings['reads']} reads, seed {settings['seed']}. "
        f"{SUMMARY[table]} From n = 10 on distances are rounded to whole metres, because plans are "
        "counted by distance.",
        "",
        *_seconds(rows, table),
        "",
        *_quality(rows),
    ]
    if empty := _empty(rows):
        lines += ["", "Left empty:", "", *empty]
    if report["interrupted"]:
        lines += ["", "This run was interrupted: rows are missing."]
    return "\n".join(lines) + "\n"


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
    devices = "; ".join(dict.fromkeys(named.values()))
    return [*markdown_table(heads, found), "", f"The paper's columns: {devices}."]


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
                figure_text(row["best"]),
                percent(row["gap"], 1),
                figure_text(row["control_best"]),
                figure_text(row["optimum"]),
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
        *markdown_table(heads, found, left={2}),
    ]


def _empty(rows: Rows) -> list[str]:
    """Return why cells are empty, one line a reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row["status"] != "done":
            key = (row["status"], row["reason"] or "no reason was given")
            found.setdefault(key, []).append(f"`{row['method']}` at n = {row['items']}")
    lines = [
        f"- {', '.join(who)}: {'failed, ' if status == 'failed' else ''}{reason}."
        for (status, reason), who in found.items()
    ]
    if any(row["items"] > 3 for row in rows):
        lines.append(
            "- VQE is run at n = 2 and 3, and the penalty form holds all 2^qubits states: beyond "
            "26 qubits only the mixers that keep the constraints are simulated, which know the n! "
            "plans alone."
        )
    return lines


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


def _plot(rows: Sequence[dict[str, Any]], table: int, path: Path) -> None:
    """Draw the seconds of a table; gids ``paper-...`` and ``ours-...`` name the lines."""
    part = "run_seconds" if table == 3 else "seconds"
    with plotted(path, (10.5, 5.6)) as (figure, axes):
        for name, label, marker in PAPER:
            points = {row["qubits"]: row[name] for row in rows if row[name] is not None}
            if points:
                axes.plot(
                    list(points), list(points.values()), marker=marker, ls=(0, (5, 2)), lw=1.6,
                    ms=7, color="#7b8794", mfc="white", mew=1.4, zorder=2,
                    label=f"paper: {label}", gid=f"paper-{name}",
                )  # fmt: skip
        for k, (name, method) in enumerate(METHODS.items()):
            own = [row for row in rows if row["method"] == name and row[part] is not None]
            if own:
                axes.plot(
                    [row["qubits"] for row in own], [max(row[part], LEAST) for row in own],
                    marker=SHAPES[k], lw=1.4, ms=6, color=colour_of(k).fill,
                    mec=colour_of(k).edge, zorder=3, label=f"ours: {method.label}",
                    gid=f"ours-{name}",
                )  # fmt: skip
        axes.set_yscale("log")
        axes.set_xticks(sorted({row["qubits"] for row in rows}))
        axes.set_xlabel("qubits of the paper's row")
        what = "seconds of sampling alone" if table == 3 else "seconds"
        axes.set_ylabel(f"{what}, logarithmic")
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_title(
            f"Table {table}: the paper's seconds ({YEAR}, dashed) and ours, on other machines",
            loc="left", size=13, weight="bold", color=INK,
        )  # fmt: skip
        figure.supxlabel(
            "Places are ours: the paper gives none. Other devices, other years: no speed-up is "
            "claimed.",
            size=8.5, x=0.01, ha="left", color="#5b6673",
        )  # fmt: skip
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9.5)


def place_text(line: Outcome) -> str:
    """Return where in the tables an outcome stands."""
    return f"table {line.table}, n = {line.items}, {line.qubits} qubits, {line.method}"


def result_text(line: Outcome) -> str:
    """Return the outcome of a method as a line of progress."""
    start = f"{place_text(line)}: "
    if line.status != "done":
        return f"{start}- ({line.reason})"
    best = "no feasible read" if line.best is None else f"best {line.best:g}"
    return (
        f"{start}{line.seconds:.2f} s, {best} of optimum {line.optimum:g}, "
        f"{line.share:.3g} of {line.reads} reads optimal"
    )


def drawn_text(figure: dict[str, Any]) -> str:
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
    parts += [drawn_text(figure) + "\n" + figure["note"] for figure in report["figures"]]
    parts += [report["places"], *report["notes"], f"Written to {folder}."]
    return "\n\n".join(parts)


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def check_page(path: str | os.PathLike[str]) -> str:
    """Return a page's text, when it has places to fill.

    Raises
    ------
    InputError
        When the page cannot be read or has no marker.
    """
    text = read_text(path)
    if "<!-- reproduce:" not in text:
        raise InputError(
            "has no place for a table",
            source=os.fspath(path),
            advice=f"write {' and '.join(MARKERS).format('table1')} into it, each on its own line",
        )
    return text


def fill_page(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> list[str]:
    """Put the Markdown files of a folder between a page's markers; return which.

    Pictures are left out: they lie in the folder.
    """
    text, filled = check_page(path), []
    for file in sorted(Path(folder).glob("*.md")):
        before, after = (marker.format(file.stem) for marker in MARKERS)
        place = re.compile(f"{re.escape(before)}\n.*?{re.escape(after)}", re.DOTALL)
        if place.search(text):
            lines = [line for line in read_text(file).splitlines() if not line.startswith("![")]
            body = re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip()
            made = f"{before}\n{body}\n\n{after}"
            text = place.sub(lambda _found, made=made: made, text)  # type: ignore[misc]
            filled.append(file.stem)
    write_text_atomic(path, text)
    return filled
