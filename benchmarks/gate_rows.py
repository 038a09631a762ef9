"""The paper's rows n = 2..12 by gate-model methods, each beside its random control.

    python -m benchmarks.gate_rows --json build/bench/gate-rows.json

Weights are the paper's (8, 8, 3, 3, 1, 2, 4) divided by 3 and rounded up, in a sequence that has
no common unit, then ones: so one robot of M = 15 (n up to 9) or 25 can carry everything. The
paper gives no places: ours are seeded. Rows that count plans by distance use distances rounded
to whole metres. Nothing is repaired, and no search knows the optimum. Times are one process on
one thread, search included, imports and the first compilation (shown apart) left out.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from benchmarks.gate_row import GateRow, grover_row, one_hot_row, penalty_row, subspace_row
from benchmarks.outputs import write
from qrobot.backends.gate import DiagonalQAOA, Form
from qrobot.study.render import markdown_table
from qrobot.study.reproduce.paper import paper_instance as paper_row
from qrobot.study.reproduce.paper import penalty_model

FIELDS = (
    ("method", "method", "{}"),
    ("n", "items", "{}"),
    ("K", "robots", "{}"),
    ("M", "capacity", "{}"),
    ("qubits", "qubits", "{}"),
    ("states", "states", "{:,}"),
    ("p", "layers", "{}"),
    ("runs", "evaluations", "{}"),
    ("seconds", "seconds", "{:.2f}"),
    ("P(optimum)", "probability", "{:.3g}"),
    ("random", "uniform", "{:.3g}"),
    ("gain", "gain", "{:.1f}"),
    ("feasible", "feasible", "{:.3g}"),
    ("random", "feasible_uniform", "{:.3g}"),
    ("seen in S shots", "seen", "{:.3g}"),
    ("random", "seen_uniform", "{:.3g}"),
    ("optimum", "distance", "{:.1f}"),
    ("best of S", "best", "{:.1f}"),
    ("random", "best_uniform", "{:.1f}"),
)


def rows(largest: int, shots: int) -> Iterator[GateRow]:
    """Yield all rows of up to `largest` items."""
    for n in range(2, min(largest, 4) + 1):
        yield penalty_row(penalty_model(paper_row(n)), shots=shots)
    yield penalty_row(penalty_model(paper_row(2, 2, 3)), shots=shots)
    for n in range(3, min(largest, 7) + 1):
        yield one_hot_row(paper_row(n), shots=shots, evaluations=24)
    for layers in (1, 4):
        before: GateRow | None = None
        for n in range(3, min(largest, 9) + 1):
            # Angles carry over: each row begins with those of the row before.
            start = None if before is None or layers == 1 else (before.gammas, before.betas)
            before = subspace_row(
                paper_row(n),
                layers=layers,
                shots=shots,
                start=start,
                evaluations=60 if start is None else 30,
            )
            yield before
    for n, robots, capacity in ((4, 2, 5), (5, 2, 6), (5, 3, 4), (6, 3, 4)):
        if n <= largest:
            for mixer in ("swap", "grover"):
                yield subspace_row(paper_row(n, robots, capacity), mixer, layers=2, shots=shots)
    for n in range(5, largest + 1):
        for layers in (1, 4, 10):
            yield grover_row(paper_row(n, whole_metres=True), layers=layers, shots=shots)
    for n, robots, capacity in ((9, 2, 8), (12, 2, 10), (12, 3, 7)):
        if n <= largest:
            row = paper_row(n, robots, capacity, whole_metres=True)
            yield grover_row(row, layers=10, shots=shots)


def warmed() -> float:
    """Compile, or load what was compiled, and return how long it took."""
    began = time.perf_counter()
    form = Form.from_bqm(penalty_model(paper_row(3)).bqm)
    DiagonalQAOA(form, alpha=0.5).value(np.array([0.1]), np.array([0.1]))
    return time.perf_counter() - began


def as_markdown(found: list[GateRow]) -> str:
    """Return the rows as a table."""
    cells = [
        ["-" if values[name] is None else form.format(values[name]) for _, name, form in FIELDS]
        for values in (row.as_dict() for row in found)
    ]
    return "\n".join(markdown_table([title for title, _, _ in FIELDS], cells, left={0})) + "\n"


def main() -> None:
    """Measure, print and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=12, choices=range(2, 13))
    parser.add_argument("--shots", type=int, default=1000)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    arguments = parser.parse_args()
    compiled = warmed()
    found = []
    for row in rows(arguments.largest, arguments.shots):
        found.append(row)
        print(
            f"{row.method:8} n={row.items:2} K={row.robots} p={row.layers:2} "
            f"{row.seconds:7.2f} s  P={row.probability:.3g}  x{row.gain:.1f} random",
            file=sys.stderr,
            flush=True,
        )
    table = as_markdown(found)
    report = {
        "what": "gate-model rows",
        "shots": arguments.shots,
        "compile_seconds": compiled,
        "rows": [row.as_dict() for row in found],
        "markdown": table,
    }
    write(report, arguments.json, arguments.markdown)
    print(table)


if __name__ == "__main__":
    main()
