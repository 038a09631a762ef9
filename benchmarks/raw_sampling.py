"""What `neal` finds by itself: no repair, no polish, only its reads, decoded.

    python -m benchmarks.raw_sampling --seeds 20 --json build/bench/raw_sampling.json

Random instances in the paper's shape: n items of 1 to 10 kg, M = max(heaviest,
ceil(1.1 W / K)), on an open floor of 100 x 100 m and in an aisle warehouse of 2 blocks with
8 aisles. Instances without any plan are drawn anew. The optimum comes from a subset dynamic
programme of this file. Each row carries the control: the best of as many random plans that
keep to the capacities. Seconds hold building, sampling and decoding.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.outputs import write
from qrobot.backends.annealing.samplers import NealSampler
from qrobot.models import PickingModel, build_model
from qrobot.problem import (
    AisleWarehouse,
    Instance,
    Item,
    OpenFloor,
    Order,
    Place,
    Point,
    Robot,
    Slot,
    Warehouse,
)
from qrobot.study.render import markdown_table

READS = 100
TRIES = 200_000
FLOORS = ("floor", "aisles")
SAME = 1e-6


def draw(where: str, items: int, robots: int, rng: np.random.Generator) -> Instance:
    """Return a random instance, with a plan or without."""
    warehouse: Warehouse
    places: list[Place]
    if where == "floor":
        x, y = rng.uniform(0, 100, 2)
        warehouse = OpenFloor(depot_x=float(x), depot_y=float(y))
        places = [Point(float(a), float(b)) for a, b in rng.uniform(0, 100, (items, 2))]
    else:
        warehouse = AisleWarehouse(aisles=8, slots=10, blocks=2)
        places = [
            Slot(int(rng.integers(8)), int(rng.integers(10)), int(rng.integers(2)))
            for _ in range(items)
        ]
    weights = rng.integers(1, 11, items).tolist()
    room = max(*weights, 0, -(-11 * sum(weights) // (10 * robots)))
    return Instance(
        warehouse=warehouse,
        items=tuple(
            Item(f"i{k + 1}", Fraction(w), place)
            for k, (w, place) in enumerate(zip(weights, places, strict=True))
        ),
        orders=tuple(Order(f"i{k + 1}", (f"i{k + 1}",)) for k in range(items)),
        robots=tuple(Robot(f"R{k + 1}", Fraction(room)) for k in range(robots)),
        name=f"{where}-{items}-{robots}",
    )


def optimum(instance: Instance) -> float:
    """Return the least distance by a dynamic programme over subsets, ``inf`` without a plan."""
    d = instance.distances
    n = instance.size
    masks = np.arange(1 << n)
    path = np.full((1 << n, n), np.inf)
    path[1 << np.arange(n), np.arange(n)] = d[0, 1:]
    for mask in range(1, 1 << n):
        for j in range(n):
            if not mask >> j & 1:
                onward = float((path[mask] + d[1:, j + 1]).min())
                path[mask | 1 << j, j] = min(path[mask | 1 << j, j], onward)
    tour = (path + d[1:, 0]).min(axis=1)
    load = (masks[:, None] >> np.arange(n) & 1) @ instance.weights
    trip = np.where(load <= instance.capacities[0], tour, np.inf)
    trip[0] = 0.0
    best = trip.copy()
    for _ in range(len(instance.robots) - 1):
        better = best.copy()
        for mask in np.flatnonzero(np.isfinite(trip))[1:]:
            rest = masks[masks & mask == 0]
            better[rest | mask] = np.minimum(better[rest | mask], trip[mask] + best[rest])
        best = better
    return float(best[-1])


def control(instance: Instance, rng: np.random.Generator) -> tuple[float, float]:
    """Return the best of `READS` random plans and the share of random deals that fit.

    Items are dealt to robots and sequenced uniformly at random; deals that overload a robot
    are drawn again, `TRIES` times at most.
    """
    n, robots = instance.size, len(instance.robots)
    d, weights, room = instance.distances, instance.weights, int(instance.capacities[0])
    found: list[float] = []
    tried = fitting = 0
    while len(found) < READS and tried < TRIES:
        deals = rng.integers(robots, size=(2_000, n))
        loads = np.stack([(deals == k) @ weights for k in range(robots)])
        fits = (loads <= room).all(axis=0)
        tried, fitting = tried + len(deals), fitting + int(fits.sum())
        for deal in deals[fits][: READS - len(found)]:
            sequence = rng.permutation(n)
            length = 0.0
            for k in range(robots):
                way = [0, *(sequence[deal[sequence] == k] + 1).tolist(), 0]
                length += float(d[way[:-1], way[1:]].sum())
            found.append(length)
    return min(found, default=math.inf), fitting / tried


@dataclass
class Read:
    """What one instance gave."""

    variables: int
    feasible: float
    optimal: float
    gap: float
    seconds: float
    control_gap: float
    control_fits: float


def measure(instance: Instance, best: float, encoding: str, seed: int) -> Read:
    sampler = NealSampler()
    begun = time.perf_counter()
    model: PickingModel = build_model(instance, encoding)
    defaults = sampler.picking_defaults(largest_distance=float(instance.distances.max()))
    defaults["num_reads"] = READS
    samples = sampler.sample(model.bqm, seed=seed, **defaults)
    feasible, distances = model.decode_all(samples)
    seconds = time.perf_counter() - begun
    random_best, fits = control(instance, np.random.default_rng(seed))
    return Read(
        variables=model.num_variables,
        feasible=float(feasible.mean()),
        optimal=float((distances <= best * (1 + SAME)).mean()),
        gap=float(distances.min()) / best - 1,
        seconds=seconds,
        control_gap=random_best / best - 1,
        control_fits=fits,
    )


def row(where: str, robots: int, items: int, encoding: str, reads: list[Read]) -> dict[str, object]:
    gaps: npt.NDArray[np.float64] = np.array([r.gap for r in reads])
    plain: npt.NDArray[np.float64] = np.array([r.control_gap for r in reads])
    some = np.isfinite(gaps)
    return {
        "where": where,
        "robots": robots,
        "items": items,
        "encoding": encoding,
        "instances": len(reads),
        "variables": float(np.mean([r.variables for r in reads])),
        "feasible_reads": float(np.mean([r.feasible for r in reads])),
        "with_feasible_read": float(some.mean()),
        "optimal": float((gaps <= SAME).mean()),
        "optimal_reads": float(np.mean([r.optimal for r in reads])),
        "mean_gap": float(gaps[some].mean()) if some.any() else None,
        "median_seconds": float(np.median([r.seconds for r in reads])),
        "worst_seconds": float(np.max([r.seconds for r in reads])),
        "control_optimal": float((plain <= SAME).mean()),
        "control_mean_gap": float(plain[np.isfinite(plain)].mean()),
        "control_fits": float(np.mean([r.control_fits for r in reads])),
    }


def cells(encodings: list[str]) -> list[tuple[int, int, list[str]]]:
    """Return robots, items and encodings: compact everywhere, the paper's at some sizes."""
    paper = [e for e in encodings if e != "compact"]
    compact = [e for e in encodings if e == "compact"]
    found = [(1, n, compact + (paper if n in (3, 6, 9, 12) else [])) for n in range(2, 13)]
    found += [
        (robots, n, compact + (paper if n in (5, 9) else []))
        for robots in (2, 3)
        for n in (3, 5, 7, 9, 12)
    ]
    return found


def run(seeds: int, encodings: list[str], *, quiet: bool = False) -> list[dict[str, object]]:
    rows = []
    for robots, items, chosen in cells(encodings):
        for where in FLOORS:
            kept: list[tuple[Instance, float]] = []
            rng = np.random.default_rng([robots, items, FLOORS.index(where)])
            while len(kept) < seeds:
                instance = draw(where, items, robots, rng)
                best = optimum(instance)
                if math.isfinite(best):
                    kept.append((instance, best))
            for encoding in chosen:
                reads = [measure(i, b, encoding, seed) for seed, (i, b) in enumerate(kept)]
                rows.append(row(where, robots, items, encoding, reads))
                if not quiet:
                    print(table(rows[-1:]).splitlines()[-1], flush=True)
    return rows


def table(rows: list[dict[str, object]]) -> str:
    heads = [
        "where", "K", "n", "encoding", "qubits", "feasible reads", "a feasible read", "optimal",
        "optimal reads", "gap of the best", "seconds (worst)", "control: optimal", "control: gap",
    ]  # fmt: skip
    cells = [
        [
            *(str(r[name]) for name in ("where", "robots", "items", "encoding")),
            f"{r['variables']:.0f}",
            f"{r['feasible_reads']:.2f}",
            f"{r['with_feasible_read']:.0%}",
            f"{r['optimal']:.0%}",
            f"{r['optimal_reads']:.3f}",
            "–" if r["mean_gap"] is None else f"{100 * float(str(r['mean_gap'])):.1f} %",
            f"{r['median_seconds']:.2f} ({r['worst_seconds']:.2f})",
            f"{r['control_optimal']:.0%}",
            f"{100 * float(str(r['control_mean_gap'])):.0f} %",
        ]
        for r in rows
    ]
    return "\n".join(markdown_table(heads, cells, left={0, 3}))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="instances of each row")
    parser.add_argument("--encodings", default="compact,reduced,full")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rows = run(arguments.seeds, arguments.encodings.split(","))
    markdown = "\n".join(
        [
            f"Simulated annealing alone, {READS} reads, {arguments.seeds} random instances a row; "
            "no repair, no polish. The control is the best of "
            f"{READS} random plans within the capacities. Written by "
            "`benchmarks/raw_sampling.py`.",
            "",
            table(rows),
            "",
        ]
    )
    report = {
        "what": "neal by itself",
        "reads": READS,
        "seeds": arguments.seeds,
        "rows": rows,
        "markdown": markdown,
    }
    write(report, arguments.json)


if __name__ == "__main__":
    main()
