"""VQE on the paper's table 2, n = 2 and 3: the optimum's raw probability against random.

    python tests/gates_sdk/figures.py --sdk qiskit --items 3 --seeds 10

Default options of each sampler, its local device; one seed makes the instance and runs the
search. ``raw``: share of the optimum among the reads, no repair; ``random``: among as many
uniform reads (its expectation, exactly); ``probability``: of the optimum in the final state,
exactly; ``ratio``: that by random's.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from gates_sdk.pickings import shortest, table2, table2_model
from gates_sdk.stacks import load

READS = 2000


def row(sdk: str, items: int, seed: int, **options: object) -> dict[str, object]:
    """Return what one seed gives."""
    model = table2_model(items, seed)
    began = time.perf_counter()
    found = load(f"{sdk}-vqe")().sample(model.bqm, seed=seed, num_reads=READS, **options)
    seconds = time.perf_counter() - began
    least = shortest(table2(items, seed))
    info = found.info
    assert abs(info["ground_energy"] - least) < 1e-6, "the model's ground is not the best plan"
    hits = int((np.abs(found.record.energy - least) < 1e-6).sum())
    uniform = info["ground_probability_uniform"]
    return {
        "sdk": sdk,
        "items": items,
        "qubits": info["qubits"],
        "seed": seed,
        "raw": hits / READS,
        "random": uniform,
        "probability": info["ground_probability"],
        "ratio": info["ground_probability"] / uniform,
        "evaluations": info["evaluations"],
        "executions": info["executions"],
        "seconds": seconds,
    }


def main() -> None:
    """Print a line a seed and a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sdk", choices=("qiskit", "pennylane", "braket"), required=True)
    parser.add_argument("--items", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--options", type=json.loads, default={}, help="more, as JSON")
    chosen = parser.parse_args()
    rows = []
    for seed in range(chosen.first, chosen.first + chosen.seeds):
        rows.append(row(chosen.sdk, chosen.items, seed, **chosen.options))
        print(
            json.dumps(
                {k: round(v, 5) if isinstance(v, float) else v for k, v in rows[-1].items()}
            ),
            flush=True,
        )
    print(
        f"{chosen.sdk} n={chosen.items} ({rows[0]['qubits']} qubits): "
        f"{sum(r['ratio'] >= 10 for r in rows)} of {len(rows)} seeds at 10x or more; median of "
        f"{np.median([r['ratio'] for r in rows]):.0f}x, "
        f"{np.median([r['seconds'] for r in rows]):.1f} s, "
        f"{np.median([r['evaluations'] for r in rows]):.0f} evaluations"
    )


if __name__ == "__main__":
    main()
