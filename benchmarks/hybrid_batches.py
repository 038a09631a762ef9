"""A sampler that batches whole orders, beside the classical search and beside random proposals.

    python -m benchmarks.hybrid_batches --seeds 3 --seconds 10 --json build/bench/hybrid.json

Files of Henn with 30 orders (`--data`), one for each capacity. Arms with the same seconds of the
processor and the same seeds: the loop of `qrobot.planning.proposals` fed by `neal`, the same loop
fed by random proposals, both without any repair ("alone"), and the classical search (`batching`).
`diversity` is the mean distance of pairs of partitions: the share of pairs of orders on one trip in
either that are not in both.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import dimod
import numpy as np

import qrobot
from benchmarks.outputs import write
from qrobot.backends import Stop, get
from qrobot.backends.annealing.samplers import NealSampler
from qrobot.models.batches import BatchModel
from qrobot.planning.batch_sampling import batch_parameters
from qrobot.planning.proposals import BatchLoop, RandomSource, SamplerSource, Source
from qrobot.problem import Instance
from qrobot.study.render import markdown_table

FILES = (
    "uniform_Largest_Gap__5l-30-30-0",
    "uniform_Largest_Gap__6l-30-45-2",
    "uniform_Largest_Gap__7l-30-60-0",
    "uniform_Largest_Gap__8l-30-75-7",
)
READS = 10
PARTS = ("assignment", "neighbourhood", "selection")
BETTER = ("better", "repaired_better")
ARMS = ("neal", "random", "neal alone", "random alone")
"""What proposes; alone: nothing is repaired."""


class ProcessorStop(Stop):
    """A stop by seconds of the processor: other work on the machine does not count."""

    def __init__(
        self,
        seconds: float | None = None,
        max_work: int | None = None,
        parent: Stop | None = None,
    ) -> None:
        super().__init__(seconds, max_work, parent)
        self.begun = time.process_time()

    @property
    def elapsed(self) -> float:
        """Seconds of this process since the start."""
        return time.process_time() - self.begun

    def within(self, seconds: float | None = None, max_work: int | None = None) -> Stop:
        """Return a stop for a part of the work."""
        return ProcessorStop(seconds, self.max_work if max_work is None else max_work, self)


def source(arm: str) -> Source:
    """Return what proposes in an arm."""
    if arm.startswith("random"):
        return RandomSource()
    sampler = NealSampler()

    def ask(model: BatchModel, scale: float, reads: int, stop: Stop, seed: int) -> dimod.SampleSet:
        asked = batch_parameters(sampler, model, scale, {"num_reads": reads}, stop, seed)
        return sampler.sample(model.bqm, **asked)

    return SamplerSource(ask)


def measure(instance: Instance, seed: int, seconds: float) -> dict[str, Any]:
    """Return what the three arms gave with one seed."""
    found: dict[str, Any] = {}
    for arm in ARMS:
        loop = BatchLoop(instance, seed, source(arm), repairs=not arm.endswith("alone"))
        loop.run(ProcessorStop(seconds), READS)
        found[arm] = dict(loop.facts())
    routes = get("batching").search(instance, stop=ProcessorStop(seconds), seed=seed).routes
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
        for part in PARTS if arm in ARMS else ():
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
        "plans of all orders", "their mean", "repaired: mean", "diversity", "repaired: diversity",
        "few trips: plans", "better by themselves", "better when repaired",
        "selections that are plans",
    ]  # fmt: skip
    return "\n".join(markdown_table(heads, [_cells(row) for row in found], left=(0, 1))) + "\n"


def _cells(row: dict[str, Any]) -> list[str]:
    cells = [row["file"].split("__")[-1], row["arm"], f"{row['mean']:.0f}", f"{row['spread']:.1f}"]
    cells.append(f"{row['gap_to_batching']:+.2%}")
    if "assignment" not in row:
        return [*cells, *[""] * 10]
    own, part, chosen = (row[name] for name in PARTS)
    cells.append(f"{sum(row[name].get('proposals', 0.0) for name in PARTS):.0f}")
    cells.append(_share(own))
    cells += [f"{own[key]:.0f}" if key in own else "" for key in ("mean", "repaired_mean")]
    cells += [
        f"{own[key]:.2f}" if key in own else "" for key in ("diversity", "repaired_diversity")
    ]
    better = [sum(row[name].get(key, 0.0) for name in PARTS) for key in BETTER]
    return [*cells, _share(part), *(f"{number:.1f}" for number in better), _share(chosen)]


def _share(tally: dict[str, float]) -> str:
    return f"{tally.get('plans', 0.0) / max(1.0, tally.get('proposals', 0.0)):.0%}"


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
        print(table(found[-len(ARMS) - 1 :]), end="", flush=True)
    settings = {"seconds": arguments.seconds, "seeds": arguments.seeds, "reads": READS}
    write({"settings": settings, "rows": found, "markdown": table(found)}, arguments.json)


if __name__ == "__main__":
    main()
