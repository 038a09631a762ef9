"""K = 2 and 3: which backends give a plan by themselves, without repair?

    PYTHONPATH=tests python -m benchmarks.feasible_reads --seeds 10

Instances in the paper's shape (tests/oracles.py), n = 2 to 5, each with a plan. A cell says in how
many instances at least one raw read is a plan, in how many one is optimal, and the mean shares of
reads that are plans and that are optimal, all from `SamplerReport`: decoded before repair and
polish; random: the same of as many uniformly random bit strings (plans, for `qaoa-*`). Local
samplers are asked again with raised weights while no read is a plan, at most 8 times.
``dwave-qpu`` is the backend with simulated annealing (5000 sweeps) on an embedded Pegasus graph in
place of the QPU, and allowed 8 jobs too (its default is one, because each bills).
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from oracles import least_distance, paper_shaped

import qrobot
from benchmarks.outputs import write
from qrobot.backends import registry
from qrobot.backends.dwave.qpu import DWaveQPUSampler
from qrobot.study.render import markdown_table

BACKENDS = ("neal", "tabu", "descent", "dwave-qpu", "qaoa-swap", "qaoa-grover")


class StandIn(DWaveQPUSampler):
    """The QPU backend with an annealer of this machine behind the embedding."""

    def __init__(self) -> None:
        from dwave.samplers import SimulatedAnnealingSampler
        from dwave.system.testing import MockDWaveSampler

        child = MockDWaveSampler(
            topology_type="pegasus",
            topology_shape=[8],
            substitute_sampler=SimulatedAnnealingSampler(),
            substitute_kwargs={"num_sweeps": 5000, "seed": 1},
        )
        super().__init__(child)


def cell(backend: str, items: int, robots: int, seeds: int) -> dict[str, object]:
    """Return what a backend gives on all instances of a size."""
    more: dict[str, Any] = {} if backend.startswith("qaoa") else {"control": True}
    more |= {"rounds": 8} if backend == "dwave-qpu" else {}
    tried = some = best = 0
    share = optimal = random = random_optimal = 0.0
    for seed in range(seeds):
        instance = paper_shaped(items, robots, 1000 + seed)
        known = least_distance(instance)
        if known is None:
            continue
        tried += 1
        try:
            result = qrobot.solve(instance, backend=backend, deadline=120, seed=seed, **more)
        except qrobot.BackendError as error:
            print(f"{backend} K={robots} n={items} seed {seed}: {error}", file=sys.stderr)
            continue
        report = result.sampler
        assert report is not None
        share += report.feasible_fraction
        optimal += report.optimal_fraction or 0.0
        random += report.random_feasible_fraction or 0.0
        random_optimal += report.random_optimal_fraction or 0.0
        if report.best is not None:
            some += 1
            best += report.best <= known[0] * (1 + 1e-9)
    return {
        "backend": backend, "robots": robots, "items": items, "instances": tried,
        "with_plan": some, "with_optimum": best, "feasible": share / max(tried, 1),
        "optimal": optimal / max(tried, 1),
        "random_feasible": random / max(tried, 1),
        "random_optimal": random_optimal / max(tried, 1),
    }  # fmt: skip


def main() -> None:
    """Print a table and, if asked, write the rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--backends", default=",".join(BACKENDS))
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="qrobot-bench-")
    registry.BUILTIN["dwave-qpu"] = ("benchmarks.feasible_reads", "StandIn", "dwave.system")
    rows = []
    heads = [
        "backend", "K", "n", "instances", "some plan", "some optimal", "feasible", "random",
        "optimal", "random",
    ]  # fmt: skip
    found: list[list[str]] = []
    for backend in chosen.backends.split(","):
        for robots in (2, 3):
            for items in (2, 3, 4, 5):
                rows.append(cell(backend, items, robots, chosen.seeds))
                r = rows[-1]
                found.append([
                    backend, str(robots), str(items),
                    *(str(r[name]) for name in ("instances", "with_plan", "with_optimum")),
                    f"{r['feasible']:.3f}", f"{r['random_feasible']:.2g}",
                    f"{r['optimal']:.3f}", f"{r['random_optimal']:.2g}",
                ])  # fmt: skip
                print(*found[-1], file=sys.stderr, flush=True)
    table = "\n".join(markdown_table(heads, found, left={0})) + "\n"
    print(table)
    write({"rows": rows, "markdown": table}, chosen.json)


if __name__ == "__main__":
    main()
