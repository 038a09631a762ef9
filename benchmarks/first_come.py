"""Plans of `auto` with shortest tours, beside first come first served with S-shape.

    python -m benchmarks.first_come --deadline 10 --json benchmarks/results/first_come.json

Every file of whole orders below `--data`, with the same robots on both sides. The baseline is what
a warehouse without a planner does: orders join the open trip as they come, and every aisle with
picks is walked through. It searches nothing. Both plans are accepted by the checker.
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import qrobot
from benchmarks.outputs import write
from qrobot.backends import Stop, get
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.study.render import markdown_table, percent
from qrobot.study.runner import measured_here
from qrobot.warehouse import under_policy

SETS = ("henn", "muter", "bahceci", "foodmart", "lorenci")
"""Folders whose orders stay whole."""


def files(data: Path) -> Iterator[tuple[str, Path]]:
    """Yield each file with its class: a folder, that of Henn by capacity."""
    for name in SETS:
        for path in sorted((data / name).iterdir()):
            if path.suffix == ".lyt":  # read with its orders
                continue
            capacity = re.search(r"-(\d+)-\d+\.txt$", path.name) if name == "henn" else None
            yield (f"Henn, capacity {capacity[1]}" if capacity else name.capitalize()), path


def question(path: Path) -> qrobot.Instance:
    """Read a file, and its layout where that is beside it."""
    layouts = sorted(path.parent.glob("*.lyt")) if path.suffix == ".ord" else []
    return qrobot.read(path, layout=layouts[0]) if layouts else qrobot.read(path)


def measure(path: Path, deadline: float) -> dict[str, Any]:
    """Return both plans of a file in numbers, or why there is no baseline."""
    instance = question(path)
    row: dict[str, Any] = {"file": path.name, "orders": len(instance.orders)}
    try:
        asked = under_policy(instance, "s-shape")
    except InputError as error:
        return row | {"refused": str(error)}
    routes = get("fcfs").search(asked, stop=Stop(), seed=0).routes
    assert routes is not None, path
    baseline = Plan.from_routes(asked, asked.in_sequence(routes))
    begun = time.perf_counter()
    found = qrobot.solve(instance, deadline=deadline)
    row["seconds"] = round(time.perf_counter() - begun, 2)
    for key, plan in (("baseline", baseline), ("auto", found.plan)):
        assert qrobot.check(plan, instance).ok, path
        row[key] = plan.distance
        row[f"{key}_trips"] = len(plan.trips)
    row["proven"] = bool(found.is_optimal)
    row["saving"] = 1.0 - row["auto"] / row["baseline"]
    return row


def table(rows: list[dict[str, Any]]) -> str:
    """Return a row for each class, and one for all files."""
    measured = [row for row in rows if "saving" in row]
    classes = {row["class"]: [r for r in measured if r["class"] == row["class"]] for row in rows}
    heads = ["files", "number", "mean saving", "least", "most", "trips: baseline", "auto"]
    cells = []
    for name, group in (*classes.items(), ("all", measured)):
        if not group:
            continue
        savings = np.array([row["saving"] for row in group])
        trips = (sum(row[f"{key}_trips"] for row in group) for key in ("baseline", "auto"))
        shares = (percent(float(x), 1) for x in (savings.mean(), savings.min(), savings.max()))
        cells.append([name, str(len(group)), *shares, *map(str, trips)])
    return "\n".join(markdown_table(heads, cells, left=(0,))) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/picking"))
    parser.add_argument("--deadline", type=float, default=10.0, help="seconds of each search")
    parser.add_argument("--match", default="", help="only files whose name contains this")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    report = {"settings": {"deadline": arguments.deadline}, **measured_here()}
    rows: list[dict[str, Any]] = []
    for name, path in files(arguments.data):
        if arguments.match in path.name:
            rows.append({"class": name, **measure(path, arguments.deadline)})
            print(rows[-1], flush=True)
    report |= {"rows": rows, "markdown": table(rows)}
    print(report["markdown"], end="")
    write(report, arguments.json)


if __name__ == "__main__":
    main()
