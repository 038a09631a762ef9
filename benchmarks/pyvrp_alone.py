"""PyVRP as it comes, with the robots' number of trips: the peer of backend auto.

    python -m benchmarks.pyvrp_alone FOLDER --robots-for 'X-*=free' -t 10 --json out.json

The same file format as `qrobot bench`, so both make one table. PyVRP gets whole distances, its
own default parameters and the same seconds; nothing of this package but the reader.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyvrp
from pyvrp.stop import MaxRuntime

from benchmarks.outputs import write
from qrobot.problem.formats import read
from qrobot.study.bench import BENCH_SCHEMA, Task, find_instances, tasks
from qrobot.study.runner import measured_here


def solve(task: Task) -> dict[str, Any]:
    instance = read(task.path, robots=task.robots)
    model = pyvrp.ProblemData(
        locations=[
            pyvrp.Location(x, y)
            for x, y in [
                instance.warehouse.depot,
                *(instance.warehouse.position(item.place) for item in instance.items),
            ]
        ],
        clients=[
            pyvrp.Client(location=i + 1, delivery=[int(item.weight)])
            for i, item in enumerate(instance.items)
        ],
        depots=[pyvrp.Depot(location=0)],
        vehicle_types=[pyvrp.VehicleType(len(instance.robots), [int(instance.robots[0].capacity)])],
        distance_matrices=[np.rint(instance.distances).astype(np.int64)],
        duration_matrices=[np.zeros(instance.distances.shape, dtype=np.int64)],
    )
    begun = time.perf_counter()
    result = pyvrp.solve(
        model, MaxRuntime(task.deadline), seed=task.seed, collect_stats=False, display=False
    )
    feasible = result.is_feasible()
    cost = float(result.cost()) if feasible else None
    reference = task.reference or instance.reference
    return {
        "instance": Path(task.path).stem,
        "backend": "PyVRP alone",
        "seed": task.seed,
        "cost": cost,
        "bound": None,
        "reference": reference,
        "gap": cost / reference - 1 if cost and reference else None,
        "proven": False,
        "feasible": feasible,
        "seconds": time.perf_counter() - begun,
        "wall_seconds": None,
        "peak_mb": None,
        "trips": result.best.num_routes(),
        "error": None,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-t", "--deadline", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--robots", type=int)
    parser.add_argument("--robots-for", action="append", default=[])
    parser.add_argument("--match", default="*")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    report: dict[str, Any] = {
        "schema": BENCH_SCHEMA,
        **measured_here(),
        "rows": [],
    }
    for task in tasks(
        find_instances(arguments.folder, arguments.match),
        ["pyvrp"],
        arguments.seeds,
        deadline=arguments.deadline,
        robots=arguments.robots,
        robots_for=arguments.robots_for,
    ):
        row = solve(task)
        report["rows"].append(row)
        print(row["instance"], row["seed"], row["cost"], row["gap"], flush=True)
        write(report, arguments.json)


if __name__ == "__main__":
    main()
