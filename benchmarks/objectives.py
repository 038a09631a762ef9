"""What plans of each objective come to by every measure: each should be best at its own.

    python -m benchmarks.objectives --json benchmarks/results/objectives.json

Instances of eight orders, which `auto` proves for every objective, drawn by seed: two blocks of
aisles, two or three robots of unlike speed and capacity, due times, set-ups. Costs only are
compared, so a busy machine changes nothing.
"""

from __future__ import annotations

import argparse
import random
from pathlib import Path
from typing import Any

import numpy as np

import qrobot
from benchmarks.outputs import write
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot, Times
from qrobot.study.render import markdown_table
from qrobot.study.runner import measured_here

OBJECTIVES = ("distance", "time", "makespan", "lateness", "trips", "robots")

SAME = 1e-9
"""Relative: costs that differ by less are equal."""


def instance(seed: int) -> Instance:
    """Draw an instance."""
    draw = random.Random(seed)
    items, orders = [], []
    for o in range(8):
        names = tuple(f"{o}-{k}" for k in range(draw.randint(1, 3)))
        items += [
            Item(
                name, draw.randint(1, 6),
                Slot(draw.randrange(6), draw.randrange(12), draw.randrange(2)),
                pick_seconds=draw.choice([3.0, 6.0]),
            )
            for name in names
        ]  # fmt: skip
        orders.append(Order(str(o), names, due=float(draw.randrange(60, 300, 20))))
    robots = tuple(
        Robot(f"R{r}", draw.choice([18, 24, 30]), draw.choice([0.8, 1.2, 1.6]), trips=8)
        for r in range(draw.randint(2, 3))
    )
    warehouse = AisleWarehouse(6, 12, 2, aisle_pitch=3.5, end_gap=1.5)
    times = Times(per_trip=20.0)
    return Instance(warehouse, tuple(items), tuple(orders), robots, name=str(seed), times=times)


def measure(seed: int) -> dict[str, Any]:
    """Return the measures of a proven plan of each objective."""
    question = instance(seed)
    row: dict[str, Any] = {"seed": seed}
    for name in OBJECTIVES:
        found = qrobot.solve(question, objective=name, deadline=60)
        assert found.is_optimal, (seed, name)
        assert found.measures is not None
        row[name] = found.measures.to_dict()
    return row


def table(rows: list[dict[str, Any]]) -> str:
    """Return the means of every measure, a row an objective."""
    cells = []
    for name in OBJECTIVES:
        means = [np.mean([row[name][measure] for row in rows]) for measure in OBJECTIVES]
        best = all(
            row[name][name] <= row[other][name] * (1 + SAME) + SAME
            for row in rows
            for other in OBJECTIVES
        )
        cells.append([name, *(f"{mean:.1f}" for mean in means), "all" if best else "not all"])
    heads = ["made for", *OBJECTIVES, "best at its own"]
    return "\n".join(markdown_table(heads, cells, left=(0,))) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=30, help="instances")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rows = [measure(seed) for seed in range(arguments.number)]
    report = {"settings": {"number": arguments.number}, **measured_here()}
    report |= {"rows": rows, "markdown": table(rows)}
    print(report["markdown"], end="")
    write(report, arguments.json)


if __name__ == "__main__":
    main()
