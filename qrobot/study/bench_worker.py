"""One run of the benchmark in a process of its own: prints one line of JSON.

``python -m qrobot.study.bench_worker '{"path": ..., "backend": ...}' PARENT``; it ends when the
process PARENT is gone, however that went.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import threading
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from qrobot._json import json_text
from qrobot.errors import InfeasibleError, QRobotError
from qrobot.planning import solve
from qrobot.problem.formats import read

__all__ = ["run"]


def run(task: dict[str, Any]) -> dict[str, Any]:
    """Solve one instance and return the row's values."""
    row: dict[str, Any] = {}
    try:
        instance = read(task["path"], robots=task["robots"], rounding=task.get("rounding"))
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
            "robots": result.plan.robots_used,
            "sampler": asdict(result.sampler) if result.sampler else None,
        }
    row["peak_mb"] = _peak_mb()
    return row


def _end_with(parent: int) -> None:
    """End this process when its parent is gone: nobody would read the row."""
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def _peak_mb() -> float:
    """Return the largest resident memory of this process, 10^6 bytes.

    Linux counts the memory of the process that started this one into `ru_maxrss`, so a
    large parent would show as a large run; its ``VmHWM`` begins anew with the program.
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
        line = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024 / 1e6
    except (OSError, StopIteration, ValueError, IndexError):
        scale = 1 if sys.platform == "darwin" else 1024
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale / 1e6


if __name__ == "__main__":
    threading.Thread(target=_end_with, args=(int(sys.argv[2]),), daemon=True).start()
    sys.stdout.write(json_text(run(json.loads(sys.argv[1]))) + "\n")
