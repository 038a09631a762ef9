"""Adjoint gradients against parameter-shift on lightning.qubit, at equal steps.

    PYTHONPATH=tests python -m benchmarks.pennylane_gradients --items 3 --steps 10

The same sampler, model, seed and optimiser (Adam); only ``diff_method`` differs. Both must
walk the same way: the histories are compared.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from stacks.pickings import table2_model

from benchmarks.outputs import write
from qrobot.backends.pennylane.sampler import PennyLaneVQE
from qrobot.study.render import markdown_table


def measure(items: int, steps: int, ansatz: str, layers: int, alpha: float) -> dict[str, float]:
    """Return seconds a step by either method, and how far their histories differ."""
    model = table2_model(items)
    seconds, histories = {}, {}
    for method in ("adjoint", "parameter-shift"):
        given = {
            "seed": 0,
            "optimizer": "adam",
            "starts": 1,
            "ansatz": ansatz,
            "layers": layers,
            "alpha": alpha,
            "diff_method": method,
        }
        PennyLaneVQE().sample(model.bqm, evaluations=1, **given)  # imports and first calls
        began = time.perf_counter()
        found = PennyLaneVQE().sample(model.bqm, evaluations=steps, **given)
        seconds[method] = (time.perf_counter() - began) / found.info["evaluations"]
        histories[method] = np.array(found.info["history"])
    apart = float(np.abs(histories["adjoint"] - histories["parameter-shift"]).max())
    return {**seconds, "ratio": seconds["parameter-shift"] / seconds["adjoint"], "apart": apart}


def main() -> None:
    """Print a line an ansatz."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--items", type=int, default=3)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    heads = ["ansatz", "layers", "alpha", "adjoint, ms a step", "parameter-shift", "ratio", "apart"]
    cells = []
    for ansatz, layers in (("hardware", 1), ("hardware", 3), ("problem", 1)):
        for alpha in (1.0, 0.05):
            found = measure(chosen.items, chosen.steps, ansatz, layers, alpha)
            milliseconds = (1e3 * found[how] for how in ("adjoint", "parameter-shift"))
            cells.append([
                ansatz, str(layers), f"{alpha:g}", *(f"{ms:.1f}" for ms in milliseconds),
                f"{found['ratio']:.1f}", f"{found['apart']:.0e}",
            ])  # fmt: skip
            print(*cells[-1], file=sys.stderr, flush=True)
    table = "\n".join(markdown_table(heads, cells, left={0})) + "\n"
    print(table)
    write({"items": chosen.items, "markdown": table}, chosen.json)


if __name__ == "__main__":
    main()
