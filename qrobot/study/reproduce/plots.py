"""Seconds against qubits: the paper's and ours, on a logarithmic scale."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from qrobot.report.palette import INK, colour_of
from qrobot.report.picture import save, style
from qrobot.study.reproduce.methods import METHODS
from qrobot.study.reproduce.paper import YEAR

__all__ = ["table_plot"]

PAPER = (
    ("paper_annealer_seconds", "annealer", "s"),
    ("paper_ibmq_seconds", "Qiskit simulator", "^"),
    ("paper_pennylane_seconds", "PennyLane", "v"),
)
MARKERS = "oDPX*phd>"
LEAST = 1e-5
"""Seconds below which a point stands at the edge."""


def table_plot(rows: Sequence[dict[str, Any]], table: int, path: Path) -> None:
    """Draw the seconds of a table; gids ``paper-...`` and ``ours-...`` name the lines.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    part = "run_seconds" if table == 3 else "seconds"
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.5, 5.6), layout="constrained", facecolor="white")
        axes = figure.add_subplot()
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
                    marker=MARKERS[k], lw=1.4, ms=6, color=colour_of(k).fill,
                    mec=colour_of(k).edge, zorder=3, label=f"ours: {method.label}",
                    gid=f"ours-{name}",
                )  # fmt: skip
        axes.set_yscale("log")
        axes.set_xticks(sorted({row["qubits"] for row in rows}))
        axes.set_xlabel("qubits of the paper's row")
        what = "seconds of sampling alone" if table == 3 else "seconds"
        axes.set_ylabel(f"{what}, logarithmic")
        axes.grid(alpha=0.3, which="major")
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
        save(figure, path)
