"""The first panel of the paper's figures: all nodes and the distances between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

from qrobot.problem import Instance
from qrobot.report.palette import DEPOT, INK
from qrobot.report.picture import save, style

__all__ = ["draw_distances"]

XY = tuple[float, float]
NODE = "#8ec5f2"


def draw_distances(instance: Instance, path: Path) -> None:
    """Draw the complete graph: node 0 yellow, items blue, as in the paper.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    house = instance.warehouse
    spots = [house.depot, *(house.position(item.place) for item in instance.items)]
    weights = [None, *(float(item.weight) for item in instance.items)]
    d = instance.distances
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 7.2), layout="constrained", facecolor="white")
        axes = figure.add_subplot(aspect="equal")
        axes.set_axis_off()
        axes.margins(0.09)
        taken = list(spots)
        for a, b in combinations(range(len(spots)), 2):
            (ax, ay), (bx, by) = spots[a], spots[b]
            axes.plot([ax, bx], [ay, by], color="#b8c2cc", lw=1.0, zorder=1)
            label = _free(spots[a], spots[b], taken)
            taken.append(label)
            axes.text(
                *label, f"{d[a, b]:.1f}", size=8, ha="center", va="center", zorder=2,
                color="#46505a",
                bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none"},
            )  # fmt: skip
        for node, (x, y) in enumerate(spots):
            axes.plot(
                [x], [y], marker="o", ms=22, mfc=NODE if node else DEPOT, mec=INK, zorder=3,
                gid=f"node-{node}",
            )  # fmt: skip
            axes.text(x, y, str(node), size=11, weight="bold", ha="center", va="center", zorder=4)
            if weights[node] is not None:
                axes.annotate(
                    f"{weights[node]:g} kg", (x, y), xytext=(0, -18), textcoords="offset points",
                    size=8.5, ha="center", va="center", zorder=4,
                    bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8},
                )  # fmt: skip
        items = len(spots) - 1
        figure.suptitle(
            f"Figure {items}: nodes and distances, m (0 is the depot; places are ours)",
            x=0.02, ha="left", size=13, weight="bold",
        )  # fmt: skip
        save(figure, path)


def _free(a: XY, b: XY, taken: Sequence[XY]) -> XY:
    """Return the spot on a way that is farthest from nodes and labels."""
    spots = [
        (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
        for t in (0.5, 0.44, 0.56, 0.38, 0.62, 0.32, 0.68, 0.26, 0.74)
    ]
    return max(spots, key=lambda spot: min(math.dist(spot, other) for other in taken))
