"""A sampler that batches whole orders, beside the classical search and beside random proposals.

    python -m benchmarks.hybrid_batches --seeds 3 --seconds 10 --json build/bench/hybrid.json

Files of Henn with 30 orders (`--data`), one for each capacity. Three arms with the same seconds
and seeds: the loop of `qrobot.planning.proposals` fed by `neal`, the same loop fed by random
proposals, and the classical search (`batching`). `diversity` is the mean distance of pairs of
partitions: the share of pairs of orders on one trip in either that are not in both.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import dimod
import numpy as np

import qrobot
from benchmarks.outputs import write
from qrobot.backends import Stop, get
from qrobot.backends.annealing.samplers import NealSampler
from qrobot.models.batches import BatchModel
from qrobot.planning.proposals import BatchLoop, RandomSource, SamplerSource, Source
from qrobot.planning.reads import call_parameters
from qrobot.problem import Instance
from qrobot.study.render import markdown_table

FILES = (
    "uniform_Largest_Gap__5l-30-30-0",
    "uniform_Largest_Gap__6l-30-45-2",
    "uniform_Largest_Gap__7l-30-60-0",
    "uniform_Largest_Gap__8l-30-75-7",
)
READS = 10
ARMS = ("neal", "random")


def source(arm: str) -> Source:
    """Return what proposes in an arm."""
    if arm == "random":
        return RandomSource()
    sampler = NealSampler()

    def ask(model: BatchModel, scale: float, reads: int, stop: Stop, seed: int) -> dimod.SampleSet:
        return sampler.sample(
            model.bqm, **call_parameters(sampler, scale, {"num_reads": reads}, stop, seed)
        )

    return SamplerSource(ask)


def measure(instance: Instance, seed: int, seconds: float) -> dict[str, Any]:
    """Return what the three arms gave with one seed."""
    found: dict[str, Any] = {}
    for arm in ARMS:
        loop = BatchLoop(instance, seed, source(arm))
        loop.run(Stop(seconds), READS)
        found[arm] = dict(loop.facts())
    routes = get("batching").search(instance, stop=Stop(seconds), seed=seed).routes
    found["batching"] = {"best": instance.length(routes)}
    return found


def rows(name: str, runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each arm."""
    classical = float(np.mean([run["batching"]["best"] for run in runs]))
    made = []
    for arm in (*ARMS, "batching"):
        best = np.array([run[arm]["best"] for run in runs])
        row: dict[str, Any] = {
            "file": name,
            "arm": arm,
            "seeds": len(runs),
            "mean": float(best.mean()),
            "spread": float(best.std()),
            "gap_to_batching": float(best.mean()) / classical - 1.0,
        }
        for part in ("assignment", "selection") if arm in ARMS else ():
            tallies = [run[arm][part] for run in runs]
            row[part] = {
                key: float(np.mean(known))
                for key in tallies[0]
                if (known := [t[key] for t in tallies if t[key] is not None])
            }
        made.append(row)
    return made


def table(found: list[dict[str, Any]]) -> str:
    heads = [
        "file", "arm", "plan: mean", "spread", "beside batching", "proposals",
        "plans by themselves", "their mean", "repaired: mean", "diversity", "repaired: diversity",
        "selections that are plans",
    ]  # fmt: skip
    return "\n".join(markdown_table(heads, [_cells(row) for row in found], left=(0, 1))) + "\n"


def _cells(row: dict[str, Any]) -> list[str]:
    cells = [row["file"].split("__")[-1], row["arm"], f"{row['mean']:.0f}", f"{row['spread']:.1f}"]
    cells.append(f"{row['gap_to_batching']:+.2%}")
    if "assignment" not in row:
        return [*cells, *[""] * 7]
    own, chosen = row["assignment"], row.get("selection", {})
    cells += [f"{own['proposals']:.0f}", f"{own['plans'] / max(1, own['proposals']):.0%}"]
    cells += [f"{own[key]:.0f}" if key in own else "" for key in ("mean", "repaired_mean")]
    cells += [
        f"{own[key]:.2f}" if key in own else "" for key in ("diversity", "repaired_diversity")
    ]
    share = chosen.get("plans", 0.0) / max(1.0, chosen.get("proposals", 0.0))
    return [*cells, f"{share:.0%}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/picking/henn"))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    found = []
    for name in FILES:
        instance = qrobot.read(arguments.data / f"{name}.txt")
        measure(instance, 0, 0.1)  # kernels are compiled before anything is timed
        runs = [measure(instance, seed, arguments.seconds) for seed in range(arguments.seeds)]
        found += rows(name, runs)
        print(table(found[-3:]), end="", flush=True)
    settings = {"seconds": arguments.seconds, "seeds": arguments.seeds, "reads": READS}
    write({"settings": settings, "rows": found, "markdown": table(found)}, arguments.json)


if __name__ == "__main__":
    main()
