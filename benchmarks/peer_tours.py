"""Tours of pywarehouse-routing: run by an interpreter that has it, questions in, answers out.

`benchmarks.peers` starts it with JSON on the standard input; it needs nothing of qrobot.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from typing import Any


def answers(question: dict[str, Any]) -> list[dict[str, Any]]:
    """Return for each trip what each strategy walks: its length, sequence and seconds."""
    peer: Any = importlib.import_module("pywarehouse")
    found = []
    for trip in question["trips"]:
        begun = time.perf_counter()
        layout = peer.WarehouseLayout.rectangular(**question["layout"])
        layout.add_products([(str(node), aisle, slot, 0) for node, aisle, slot in trip])
        for place in (layout.set_start, layout.set_finish):
            place(x=question["depot_x"], y=0.0)
        graph, attributes, _ = layout.build_graph()
        router = peer.Router(layout, graph, attributes)
        built = time.perf_counter() - begun
        row = {}
        for strategy in question["strategies"]:
            begun = time.perf_counter()
            route = router.solve(strategy=strategy)
            row[strategy] = {
                "length": float(route.total_distance),
                "sequence": [int(k) for k in route.terminal_sequence if str(k).isdecimal()],
                "seconds": built + time.perf_counter() - begun,
            }
        found.append(row)
    return found


if __name__ == "__main__":
    json.dump(answers(json.load(sys.stdin)), sys.stdout)
