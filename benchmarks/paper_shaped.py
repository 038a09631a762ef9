"""Backend auto on 200 random instances in the paper's shape, against a subset programme.

    PYTHONPATH=tests python -m benchmarks.paper_shaped --json build/bench/paper-shaped.json

n = 2..12 items, K = 1..4 robots, tight capacity: M = max(heaviest, ceil(1.1 W / K)). The
optimum (or that none exists) comes from `tests/oracles.py`, which shares no code with the
package. Times are `solve`'s own, without imports and without reading.
"""

from __future__ import annotations

import argparse
import statistics
from pathlib import Path

from oracles import paper_shaped, subset_programme

import qrobot
from benchmarks.outputs import write
from qrobot.backends import Stop


def measure(count: int) -> dict[str, object]:
    rows = []
    cells = [(n, k) for n in range(2, 13) for k in range(1, 5)]
    for number in range(count):
        n, k = cells[number % len(cells)]
        instance = paper_shaped(n, k, number // len(cells))
        expected = subset_programme(instance)
        clock = Stop()
        try:
            result = qrobot.solve(instance, deadline=10.0)
            cost, proven = result.cost, result.is_optimal
        except qrobot.InfeasibleError as error:
            cost, proven = None, error.proven
        seconds = clock.elapsed
        same = (
            cost is None
            if expected is None
            else cost is not None and (abs(cost - expected) <= 1e-9 * expected)
        )
        rows.append(
            {
                "instance": instance.name,
                "items": n,
                "robots": k,
                "expected": expected,
                "cost": cost,
                "equal": same,
                "proven": proven,
                "seconds": seconds,
            }
        )
    seconds = [row["seconds"] for row in rows]
    return {
        "what": "backend auto on paper-shaped random instances",
        "instances": len(rows),
        "equal": sum(bool(row["equal"]) for row in rows),
        "proven": sum(bool(row["proven"]) for row in rows),
        "infeasible": sum(row["expected"] is None for row in rows),
        "median_seconds": statistics.median(seconds),
        "worst_seconds": max(seconds),
        "rows": rows,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    report = measure(arguments.count)
    write(report, arguments.json)
    print({key: value for key, value in report.items() if key != "rows"})


if __name__ == "__main__":
    main()
