"""The charts of the benchmarks' page, drawn from the measured JSON when the site is built.

Each stands below the heading of its part. Long tables fold; what is in them stays searchable.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from qrobot.pages import Bar, bars

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks/results"
PAGE = "benchmarks.md"
LONG = 14
"""Lines of a table that folds."""

Rows = Iterator[Bar]


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Draw the charts of the page of the benchmarks, fold its long tables."""
    if page.file.src_uri != PAGE:
        return markdown
    for name, (heading, title, rows) in CHARTS.items():
        path = RESULTS / f"{name}.json"
        found = re.search(rf"^## {re.escape(heading)}.*\n", markdown, re.MULTILINE)
        if not path.exists():
            continue
        if not found:
            raise PluginError(f"{PAGE} has no part '{heading}' for the chart of {path.name}")
        chart = figure(name, title, list(rows(json.loads(path.read_text()))))
        markdown = f"{markdown[: found.end()]}\n{chart}\n{markdown[found.end() :]}"
    return re.sub(rf"(?:^\|.*\n){{{LONG},}}", folded, markdown, flags=re.MULTILINE)


def figure(name: str, title: str, rows: Sequence[Bar]) -> str:
    """Return a chart with its title, on lines that Markdown leaves alone."""
    chart = str(bars(f"chart-{name}", title, rows)).replace("\n", "")
    return f'<figure class="chart-figure"><figcaption>{title}</figcaption>{chart}</figure>\n'


def folded(table: re.Match[str]) -> str:
    """Return a table below a line that opens it."""
    lines = table[0].splitlines()
    inside = [f"    {line}" for line in lines]
    return "\n".join([f'??? abstract "Table of {len(lines) - 2} rows"', "", *inside, ""])


def bar(name: str, value: float, digits: int) -> Bar:
    """Return a bar that shows its value with some digits."""
    return Bar(name, (value,), f"{value:.{digits}f}")


# --- what the charts show -------------------------------------------------------------------------


def startup(result: dict[str, Any]) -> Rows:
    for name, key in (
        ("import click", "click_seconds"),
        ("import qrobot", "import_seconds"),
        ("qrobot --help", "help_seconds"),
    ):
        yield bar(name, 1000 * result[key], 0)


def paper(result: dict[str, Any]) -> Rows:
    rows = sorted(result["rows"], key=lambda row: row["items"])
    for items, group in groupby(rows, key=lambda row: row["items"]):
        seconds = median(row["seconds"] for row in group)
        yield bar(f"{items} items", 1000 * seconds, 1)


def raw(result: dict[str, Any]) -> Rows:
    for row in result["rows"]:
        if row["robots"] == 1 and row["encoding"] == "compact" and row["where"] == "aisles":
            for who, key in (("neal", "optimal"), ("random", "control_optimal")):
                yield bar(f"{row['items']} items, {who}", 100 * row[key], 0)


def gates(result: dict[str, Any]) -> Rows:
    shots = result["shots"]

    def seen(probability: float) -> float:
        return 1 - (1 - probability) ** shots

    for row in result["rows"]:
        if row["items"] == 7 and row["robots"] == 1:
            name = f"{row['method']}, p = {row['layers']}"
            for who, key in ((name, "probability"), (f"{name}, random", "uniform")):
                yield bar(who, seen(row[key]), 3)


def vqe(result: dict[str, Any]) -> Rows:
    rows = sorted(result["rows"], key=lambda row: (row["sdk"], row["items"]))
    for (sdk, items), group in groupby(rows, key=lambda row: (row["sdk"], row["items"])):
        share = median(row["raw"] for row in group)
        yield bar(f"{sdk}, {items} items", 100 * share, 1)


def layer(result: dict[str, Any]) -> Rows:
    for row in result["rows"]:
        if (row["qubits"], row["precision"]) == (24, "double"):
            for name, times in row.items():
                if isinstance(times, dict):
                    yield bar(name, times["cpu"], 2)


def plans(result: dict[str, Any]) -> Rows:
    for row in result["rows"]:
        if row["robots"] == 3 and row["items"] == 5:
            yield bar(row["backend"], 100 * row["feasible"], 1)


def gaps(result: dict[str, Any]) -> Rows:
    for row in result["rows"]:
        if row["backend"] == "auto":
            yield bar(row["instance"], 100 * (row["gap"] or 0.0), 2)


def seconds(result: dict[str, Any]) -> Rows:
    for row in result["rows"]:
        yield bar(row["instance"], row["seconds"], 2)


CHARTS: dict[str, tuple[str, str, Callable[[dict[str, Any]], Rows]]] = {
    "startup": ("Starting up", "Milliseconds until the command or the import is done", startup),
    "paper": ("Paper-shaped", "Median time of backend auto until the proof, milliseconds", paper),
    "raw": (
        "What `neal` finds",
        "One robot, aisles: best of 100 reads (of 100 random plans) optimal, per cent",
        raw,
    ),
    "gates": (
        "The paper's rows in the gate model",
        "Seven items, one robot, p layers: probability to see an optimal plan in 1,000 shots",
        gates,
    ),
    "vqe": ("VQE by itself", "Reads that are an optimal plan, per cent, median of ten seeds", vqe),
    "layer": ("One QAOA layer", "Seconds for one layer of 24 qubits in double precision", layer),
    "plans": (
        "Plans among the raw reads",
        "Five items, three robots: reads that are a plan, per cent",
        plans,
    ),
    "qoblib": ("QOBLIB", "Seconds until the proof", seconds),
    "cvrplib": ("CVRPLIB", "Distance above the best known value, per cent", gaps),
}
"""By the name of the results: the beginning of the part's heading, the title, the bars."""
