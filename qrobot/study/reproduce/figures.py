"""Figures 4 and 7: the same weights, the fleet of the captions, and fleets that must share.

The captions say capacity 45 and show plans with one, two and three robots. The weights sum to
22 and 29: one robot can carry everything, and with distances that keep the triangle inequality
a second trip never shortens the way. So at M = 45 the shortest plan has one robot. Smaller
capacities, chosen by us, make two and three robots necessary; both are drawn and proven.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from qrobot._files import write_text_atomic
from qrobot.errors import BackendError, InfeasibleError
from qrobot.planning import Result, solve
from qrobot.problem import Instance
from qrobot.report.palette import DEPOT, INK
from qrobot.report.picture import check_picture_path, plot
from qrobot.study.render import plotted
from qrobot.study.reproduce.paper import FIGURE_WEIGHTS, PLACES, TITLE, YEAR, figure_instance

__all__ = ["FIGURES", "draw_figure"]

PRINTED = 45
"""M in both captions."""

FIGURES = {"figure4": (4, 3, (PRINTED, 15, 8)), "figure7": (7, 4, (PRINTED, 20, 12))}
"""Items, robots of the caption, and capacities: the caption's, then ours."""

NOTE = (
    "Note: the items weigh {total} together and a robot carries 45, so one robot is always "
    "optimal as long as distances keep the triangle inequality, whatever the places. The paper's "
    "panels with two and three robots at capacity 45 need a smaller M, a tie, or distances that "
    "do not form a metric; the smaller capacities here are ours."
)


XY = tuple[float, float]
NODE = "#8ec5f2"


def draw_figure(name: str, folder: Path, seed: int) -> dict[str, Any]:
    """Draw a figure's panels into a folder and return what they show.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    BackendError
        When a plan is not proven, or fewer robots would do.
    """
    items, robots, capacities = FIGURES[name]
    check_picture_path(f"{name}.svg")
    total = sum(FIGURE_WEIGHTS[:items])
    panels: list[dict[str, Any]] = []
    report = {
        "figure": name,
        "items": items,
        "robots": robots,
        "weights": list(FIGURE_WEIGHTS[:items]),
        "places": PLACES.format(seed=seed) + ".",
        "note": NOTE.format(total=total),
        "panels": panels,
        "files": [f"{name}-distances.svg", f"{name}-distances.png", f"{name}.md"],
    }
    for suffix in ("svg", "png"):
        _draw_distances(
            figure_instance(items, robots, capacities[0], seed),
            folder / f"{name}-distances.{suffix}",
        )
    for capacity in capacities:
        result, fewer = _proven(figure_instance(items, robots, capacity, seed))
        files = [f"{name}-m{capacity}.{suffix}" for suffix in ("svg", "png")]
        for file in files:
            plot(_titled(result), folder / file)
        report["files"] += files  # type: ignore[operator]
        panels.append(
            {
                "capacity": capacity,
                "of_the_paper": capacity == PRINTED,
                "robots_used": result.plan.robots_used,
                "distance": result.cost,
                "proven": result.is_optimal,
                "fewer_robots": fewer,
                "trips": [
                    {"robot": t.robot, "stops": list(t.stops), "load": float(t.load)}
                    for t in result.plan.trips
                ],
                "files": files,
            }
        )
    write_text_atomic(folder / f"{name}.md", _markdown(report))
    return report


def _proven(instance: Instance) -> tuple[Result, str]:
    """Return the shortest plan, and why fewer robots would not do."""
    result = solve(instance, backend="exact", deadline=60)
    used = result.plan.robots_used
    if not result.is_optimal:
        raise BackendError(f"the exact planner did not prove the plan of {instance.name}")
    if used == 1:
        return result, "one robot is the least"
    try:
        solve(replace(instance, robots=instance.robots[: used - 1]), backend="exact", deadline=60)
    except InfeasibleError as error:
        return result, f"{used - 1} cannot: {error.reason.partition('; ')[0]}"
    return result, f"{used - 1} could, by a longer way"


def _titled(result: Result) -> Result:
    used = result.plan.robots_used
    count = "one robot" if used == 1 else f"{used} robots"
    whose = "as printed" if result.instance.robots[0].capacity == PRINTED else "ours"
    name = f"{result.instance.name} ({whose}), {count}"
    return replace(result, instance=replace(result.instance, name=name))


def _markdown(report: dict[str, Any]) -> str:
    name, items = report["figure"], report["items"]
    lines = [
        f"### The paper's figure {items}",
        "",
        f"{items} items of {', '.join(map(str, report['weights']))} kg and up to "
        f"{report['robots']} robots, as in “{TITLE}” ({YEAR}). {report['places']}",
        "",
        report["note"],
        "",
        f"![distances]({name}-distances.svg)",
        "",
        "| M | whose M | robots used | distance | fewer robots |",
        "|--:|---|--:|--:|---|",
    ]
    lines += [
        f"| {p['capacity']} | {'the paper’s' if p['of_the_paper'] else 'ours'} "
        f"| {p['robots_used']} | {p['distance']:.2f} m, proven | {p['fewer_robots']} |"
        for p in report["panels"]
    ]
    for p in report["panels"]:
        lines += ["", f"![M = {p['capacity']}]({p['files'][0]})"]
    return "\n".join(lines) + "\n"


def _draw_distances(instance: Instance, path: Path) -> None:
    """Draw the complete graph: node 0 yellow, items blue, as in the paper."""
    house = instance.warehouse
    spots = [house.depot, *(house.position(item.place) for item in instance.items)]
    weights = [None, *(float(item.weight) for item in instance.items)]
    d = instance.distances
    with plotted(path, (8.4, 7.2)) as (figure, axes):
        axes.set_aspect("equal")
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


def _free(a: XY, b: XY, taken: Sequence[XY]) -> XY:
    """Return the spot on a way that is farthest from nodes and labels."""
    spots = [
        (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
        for t in (0.5, 0.44, 0.56, 0.38, 0.62, 0.32, 0.68, 0.26, 0.74)
    ]
    return max(spots, key=lambda spot: min(math.dist(spot, other) for other in taken))
