"""VQE on the paper's table 2, n = 2 and 3: what it reads by itself, beside random reads.

    PYTHONPATH=tests python -m benchmarks.vqe_rows --sdk qiskit,braket --items 2,3 --seeds 10

Default options of each sampler on its local device; one seed makes the instance and runs the
search. Nothing is repaired. ``P(optimum)``: of the final state, exactly; ``raw``: the share of
optimal reads among the 2,000; ``random``: the same of uniform bit strings (exactly, by counting).
``feasible``: reads that are plans, beside the share of all bit strings; ``best read optimal``: the
raw best against the proven optimum. Seconds
are wall-clock: search and reads, imports and compilation left out (one run before).
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import dimod
import numpy as np
from stacks.pickings import shortest, table2, table2_model

from benchmarks.outputs import write
from qrobot.backends import get
from qrobot.backends.gate.form import bits_of
from qrobot.study.render import markdown_table

READS = 2000
HEADS = (
    "SDK", "n", "qubits", "raw >= 10 x random", "P(optimum)", "raw", "random", "ratio", "feasible",
    "random", "best read optimal", "runs", "seconds",
)  # fmt: skip


def row(sdk: str, items: int, seed: int, **options: Any) -> dict[str, Any]:
    """Return what one seed gives."""
    model = table2_model(items, seed)
    began = time.perf_counter()
    found = get(f"{sdk}-vqe").sample(model.bqm, seed=seed, num_reads=READS, **options)
    seconds = time.perf_counter() - began
    least = shortest(table2(items, seed))
    info = found.info
    assert abs(info["ground_energy"] - least) < 1e-6, "the model's ground is not the best plan"
    feasible, lengths = model.decode_all(found)
    uniform = info["ground_probability_uniform"]
    return {
        "sdk": sdk,
        "items": items,
        "qubits": info["qubits"],
        "seed": seed,
        "raw": int((np.abs(found.record.energy - least) < 1e-6).sum()) / READS,
        "probability": info["ground_probability"],
        "random": uniform,
        "ratio": info["ground_probability"] / uniform,
        "feasible": float(feasible.mean()),
        "random_feasible": feasible_by_chance(items, seed),
        "best": float(lengths[feasible].min()) if feasible.any() else None,
        "optimum": least,
        "evaluations": info["evaluations"],
        "executions": info["executions"],
        "seconds": seconds,
    }


def feasible_by_chance(items: int, seed: int) -> float:
    """Return the share of all bit strings that are plans, by judging every one."""
    model = table2_model(items, seed)
    bits = bits_of(np.arange(1 << model.num_variables), model.num_variables)
    every = dimod.SampleSet.from_samples(
        (bits, model.variables), vartype="BINARY", energy=np.zeros(len(bits))
    )
    return float(model.decode_all(every)[0].mean())


def summary(rows: list[dict[str, Any]]) -> list[str]:
    """Return the rows of one SDK and size as one line of a table."""
    probability, ratio, raw, feasible, chance, seconds, evaluations = (
        np.median([one[name] for one in rows])
        for name in (
            "probability", "ratio", "raw", "feasible", "random_feasible", "seconds",
            "evaluations",
        )
    )  # fmt: skip
    first = rows[0]
    hit = sum(one["best"] is not None and one["best"] < one["optimum"] + 1e-6 for one in rows)
    often = sum(one["raw"] >= 10 * one["random"] for one in rows)
    return [
        *(str(first[name]) for name in ("sdk", "items", "qubits")),
        f"{often} of {len(rows)}",
        f"{probability:.3f}",
        f"{raw:.3f}",
        f"{first['random']:.1e}",
        f"{ratio:.0f}",
        f"{feasible:.2f}",
        f"{chance:.2g}",
        f"{hit} of {len(rows)}",
        f"{evaluations:.0f}",
        f"{seconds:.1f}",
    ]


def main() -> None:
    """Print a line a seed (on the error stream) and a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sdk", default="qiskit,pennylane,braket")
    parser.add_argument("--items", default="2,3")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--options", type=json.loads, default={}, help="more, as JSON")
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    kept: list[dict[str, Any]] = []
    found: list[list[str]] = []
    for sdk in chosen.sdk.split(","):
        row(sdk, 2, 0, evaluations=2, starts=1)  # imports and compilation
        for items in map(int, chosen.items.split(",")):
            rows = []
            for seed in range(chosen.first, chosen.first + chosen.seeds):
                rows.append(row(sdk, items, seed, **chosen.options))
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
            found.append(summary(rows))
            kept += rows
    table = "\n".join(markdown_table(HEADS, found, left={0})) + "\n"
    print(table)
    write({"reads": READS, "rows": kept, "markdown": table}, chosen.json)


if __name__ == "__main__":
    main()
