"""One run of the benchmark in a process of its own: prints one line of JSON.

``python -m qrobot.study.bench_worker '{"path": ..., "backend": ...}'``; it ends when the process
that started it is gone, however that went.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import Any

from qrobot._json import json_text
from qrobot._machine import peak_memory
from qrobot._processes import end_with_parent
from qrobot.errors import InfeasibleError, QRobotError
from qrobot.plan.objective import DISTANCE
from qrobot.planning import solve
from qrobot.problem.formats import read
from qrobot.study.variants import variant_of

__all__ = ["run"]


def run(task: dict[str, Any]) -> dict[str, Any]:
    """Solve one instance and return the row's values."""
    row: dict[str, Any] = {}
    try:
        instance = read(task["path"], robots=task["robots"], rounding=task.get("rounding"))
        if task.get("variant"):
            instance = variant_of(instance, task["variant"])
        objective = task.get("objective", DISTANCE.name)
        if objective == DISTANCE.name:  # what files know of is a distance
            row["reference"] = instance.reference
        result = solve(
            instance,
            backend=task["backend"],
            deadline=task["deadline"],
            max_work=task["max_work"],
            seed=task["seed"],
            objective=objective,
        )
    except InfeasibleError as error:
        row |= {"error": str(error), "proven": error.proven}
    except QRobotError as error:
        row["error"] = str(error)
    else:
        row |= {
            "cost": result.cost,
            "bound": result.bound,
            "proven": result.is_optimal,
            "feasible": True,
            "seconds": result.timing.total,
            "trips": len(result.plan.trips),
            "robots": result.plan.robots_used,
            "sampler": asdict(result.sampler) if result.sampler else None,
        }
    row["peak_mb"] = peak_memory() / 1e6
    return row


if __name__ == "__main__":
    end_with_parent()
    sys.stdout.write(json_text(run(json.loads(sys.argv[1]))) + "\n")
