"""Tours of pywarehouse-routing beside the shortest ones, for the same layouts and stops.

    python -m benchmarks.peers --peer-python VENV/bin/python --json benchmarks/results/peers.json

The peer is installed where `--peer-python` is, not in the environment of this project. Trips are
those of first come first served in files of Henn and Muter: one block, the depot on the first
cross aisle. A peer's tour counts by what it says itself (`walked`), and by the shortest ways along
its sequence of stops (`along`), which is never longer. The checker measures both sides' sequences.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import qrobot
from benchmarks.outputs import write
from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.study.render import markdown_table, percent
from qrobot.study.runner import measured_here
from qrobot.warehouse import Router

STRATEGIES = ("s_shape", "return", "midpoint", "largest_gap", "combined")
SAME = 1e-9
"""Lengths nearer to each other than this share are one length."""


def trips_of(instance: Instance) -> list[list[int]]:
    """Return first come first served trips, as one stop for each slot that they pick in."""
    room = 0
    trips: list[dict[Slot, int]] = []
    for nodes, weight in zip(instance.order_nodes, instance.order_weights.tolist(), strict=True):
        if not trips or weight > room:
            trips.append({})
            room = int(instance.vehicle_capacities.max())
        room -= weight
        for node in nodes:
            trips[-1].setdefault(_slot(instance, node), node)
    return [list(trip.values()) for trip in trips]


def _slot(instance: Instance, node: int) -> Slot:
    place = instance.items[node - 1].place
    assert isinstance(place, Slot)
    return Slot(place.aisle, place.slot)  # both sides of an aisle are one stop


def question(instance: Instance, trips: list[list[int]]) -> dict[str, Any]:
    """Return the layout and the stops as the peer takes them: on a grid as fine as both lengths."""
    house = instance.warehouse
    assert isinstance(house, AisleWarehouse)
    gap, pitch = (Fraction(str(x)) for x in (house.end_gap, house.slot_pitch))
    least = math.lcm(gap.denominator, pitch.denominator)
    unit = Fraction(math.gcd(int(gap * least), int(pitch * least)), least)
    first, step = int(gap / unit), int(pitch / unit)
    slots = [[(node, _slot(instance, node)) for node in trip] for trip in trips]
    return {
        "layout": {
            "num_aisles": house.aisles,
            "slots_per_block": 2 * first + (house.slots - 1) * step,
            "aisle_spacing": house.aisle_pitch,
            "slot_pitch": float(unit),
        },
        "depot_x": house.depot_aisle * house.aisle_pitch,
        "strategies": STRATEGIES,
        "trips": [[(n, s.aisle, first + s.slot * step) for n, s in trip] for trip in slots],
    }


def measured(instance: Instance, routes: list[list[int]]) -> float:
    """Return the length of some trips as the checker measures it."""
    plan = Plan.from_routes(instance, routes)
    kinds = {problem.kind for problem in qrobot.check(plan, instance).problems}
    # Trips have one stop for each slot: what else lies there is "missing", nothing else may be.
    assert kinds <= {"missing", "orders", "load"}, kinds
    return plan.distance


def measure(path: Path, python: str) -> dict[str, Any]:
    """Return the lengths and seconds of a file."""
    instance = qrobot.read(path)
    house = instance.warehouse
    assert isinstance(house, AisleWarehouse)
    trips = trips_of(instance)
    router = Router(house, compiled=False)
    begun = time.perf_counter()
    tours = [router.tour([_slot(instance, node) for node in trip]) for trip in trips]
    seconds = time.perf_counter() - begun
    routes = [[trip[k] for k in tour.sequence] for trip, tour in zip(trips, tours, strict=True)]
    row: dict[str, Any] = {"file": path.name, "trips": len(trips), "seconds": seconds}
    row["shortest"] = measured(instance, routes)
    asked = subprocess.run(
        [python, str(Path(__file__).with_name("peer_tours.py"))],
        input=json.dumps(question(instance, trips)),
        capture_output=True,
        text=True,
        check=True,
    )
    answers = json.loads(asked.stdout)
    for name in STRATEGIES:
        theirs = [answer[name] for answer in answers]
        for trip, answer in zip(trips, theirs, strict=True):
            assert sorted(trip) == sorted(answer["sequence"]), (path, name)
        row[name] = {
            "walked": sum(answer["length"] for answer in theirs),
            "along": measured(instance, [answer["sequence"] for answer in theirs]),
            "seconds": sum(answer["seconds"] for answer in theirs),
            "shorter_than_ours": sum(
                answer["length"] < tour.length * (1 - SAME)
                for answer, tour in zip(theirs, tours, strict=True)
            ),
        }
    return row


def table(rows: list[dict[str, Any]]) -> str:
    """Return a row for each strategy, means over the files."""
    heads = ["strategy", "above the shortest tours: walked", "least", "along its sequence", "least",
             "trips shorter than ours", "seconds a trip", "ours"]  # fmt: skip
    trips = sum(row["trips"] for row in rows)
    cells = []
    for name in STRATEGIES:
        above = {
            key: [row[name][key] / row["shortest"] - 1.0 for row in rows]
            for key in ("walked", "along")
        }
        shares = [
            percent(share)
            for values in above.values()
            for share in (sum(values) / len(values), min(values))
        ]
        times = (sum(row[name]["seconds"] for row in rows), sum(row["seconds"] for row in rows))
        shorter = sum(row[name]["shorter_than_ours"] for row in rows)
        cells.append([name, *shares, str(shorter), *(f"{t / trips:.4f}" for t in times)])
    return "\n".join(markdown_table(heads, cells, left=(0,))) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/picking"))
    parser.add_argument("--peer-python", required=True, help="an interpreter that has the peer")
    parser.add_argument("--every", type=int, default=1, help="only each such file")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    paths = [p for name in ("henn", "muter") for p in sorted((arguments.data / name).iterdir())]
    report = {"settings": {"every": arguments.every}, **measured_here()}
    rows = []
    for path in paths[:: arguments.every]:
        rows.append(measure(path, arguments.peer_python))
        print(json.dumps(rows[-1]), flush=True)
    report |= {"rows": rows, "markdown": table(rows)}
    print(report["markdown"], end="")
    write(report, arguments.json)


if __name__ == "__main__":
    main()
