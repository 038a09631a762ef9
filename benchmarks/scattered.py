"""Places chosen together with the tour: seconds of a choice, and its value beside the published.

    python -m benchmarks.scattered --repeats 3 --json build/bench/scattered.json

Every file of `--data`, as it is and cut in two blocks. Seconds are those of the processor, of
`choose_places` alone (the file is read, the kernels are compiled), the least of some repeats, so
that other work on the machine counts little. `by` says what proved the tour: `labels` or the
integer programme.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from statistics import median
from typing import Any
from unittest import mock

import qrobot
from benchmarks.outputs import write
from qrobot.backends import Stop
from qrobot.backends.classical import scattered
from qrobot.problem import Instance
from qrobot.study.references import reference_of
from qrobot.study.render import markdown_table
from qrobot.study.variants import variant_of

VARIANTS = {1: None, 2: "two_blocks"}
"""Name of the published value by number of blocks."""


def measure(instance: Instance, repeats: int, deadline: float) -> dict[str, Any]:
    """Return value, proof and seconds of a question."""
    seconds, wall = [], []
    with mock.patch.object(scattered, "_solve", wraps=scattered._solve) as programme:
        for _ in range(repeats):
            begun, clock = time.process_time(), time.perf_counter()
            placed = scattered.choose_places(instance, Stop(deadline))
            seconds.append(time.process_time() - begun)
            wall.append(time.perf_counter() - clock)
    value = None if placed is None else placed.instance.route_length(placed.route)
    return {
        "value": value,
        "proven": placed is not None and value is not None and value <= placed.bound + 1e-6,
        "by": "programme" if programme.called else "labels",
        "seconds": min(seconds),
        "elapsed": min(wall),
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Return the medians of each class."""
    heads = ["demand", "blocks", "files", "proven", "by labels", "as published", "below", "above",
             "seconds: median", "most"]  # fmt: skip
    cells = []
    for demand in ("unit", "varying"):
        for blocks in VARIANTS:
            part = [r for r in rows if (r["demand"], r["blocks"]) == (demand, blocks)]
            if not part:
                continue
            beyond = [r["value"] - r["published"] for r in part if r["value"] is not None]
            seconds = [r["seconds"] for r in part]
            counts = [
                len(part),
                sum(r["proven"] for r in part),
                sum(r["by"] == "labels" for r in part),
                sum(abs(d) < 1e-6 for d in beyond),
                sum(d < -1e-6 for d in beyond),
                sum(d > 1e-6 for d in beyond),
            ]
            times = [f"{median(seconds):.3f}", f"{max(seconds):.3f}"]
            cells.append([demand, str(blocks), *map(str, counts), *times])
    return "\n".join(markdown_table(heads, cells, left=(0,))) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data/picking/sprp_ss"))
    parser.add_argument("--match", default="*.txt")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--deadline", type=float, default=300.0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for path in sorted(arguments.data.glob(arguments.match)):
        if not rows:  # kernels are compiled before anything is timed
            scattered.choose_places(qrobot.read(path), Stop())
        for blocks, variant in VARIANTS.items():
            known = reference_of(path, arguments.data, variant)
            instance = qrobot.read(path)
            instance = variant_of(instance, variant) if variant else instance
            row = {
                "file": path.stem,
                "demand": path.stem.split("_")[0],
                "blocks": blocks,
                "published": known and known.value,
                **measure(instance, arguments.repeats, arguments.deadline),
            }
            rows.append(row)
            print(*row.values(), flush=True)
    print(table(rows))
    write({"rows": rows, "markdown": table(rows)}, arguments.json)


if __name__ == "__main__":
    main()
