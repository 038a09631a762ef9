"""One run of the benchmark in a process of its own: prints one line of JSON.

``python -m qrobot.report.bench_worker '{"path": ..., "backend": ...}'``
"""

from __future__ import annotations

import json
import resource
import sys
from dataclasses import asdict
from typing import Any

from qrobot.errors import InfeasibleError, QRobotError
from qrobot.planning import solve
from qrobot.problem.formats import read

__all__ = ["run"]


def run(task: dict[str, Any]) -> dict[str, Any]:
    """Solve one instance and return the row's values."""
    row: dict[str, Any] = {}
    try:
        instance = read(task["path"], robots=task["robots"])
        row["reference"] = instance.reference
        result = solve(
            instance,
            backend=task["backend"],
            deadline=task["deadline"],
            max_work=task["max_work"],
            seed=task["seed"],
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
            "sampler": asdict(result.sampler) if result.sampler else None,
        }
    row["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    return row


if __name__ == "__main__":
    print(json.dumps(run(json.loads(sys.argv[1]))))
