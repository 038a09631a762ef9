"""The page docs/benchmarks.md, made from the measured JSON alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from qrobot.study.bench_report import bench_markdown

HEAD = """# Benchmarks

Written by `make bench` from `benchmarks/results/*.json`; do not edit. Every part names the machine
that it was measured on. `auto` and `pyvrp` get the same seconds and the same number of robots.
"""


def page(results: Path) -> str:
    """Return the whole page from the results that are there."""
    parts: dict[str, Callable[[dict[str, Any]], str]] = {
        "startup": startup,
        "paper": paper,
        "raw": raw,
        "gates": lambda r: section(
            r, "The paper's rows in the gate model", "benchmarks/gate_rows.py", GATES
        ),
        "vqe": lambda r: section(r, "VQE by itself", "benchmarks/vqe_rows.py", VQE),
        "layer": lambda r: section(r, "One QAOA layer", "benchmarks/qaoa_layer.py", LAYER),
        "gradients": lambda r: section(
            r, "PennyLane's gradients", "benchmarks/pennylane_gradients.py", GRADIENTS
        ),
        "plans": lambda r: section(
            r, "Plans among the raw reads, K = 2 and 3", "benchmarks/feasible_reads.py", PLANS
        ),
        "batches": lambda r: section(
            r, "Batches of whole orders by a sampler", "benchmarks/hybrid_batches.py", BATCHES
        ),
        "examples": lambda r: bench_markdown(r, "The examples, 5 seconds"),
        "qoblib": lambda r: bench_markdown(
            r, "QOBLIB, 20 items, 4 robots, no slack, deadline 10 seconds"
        ),
        "cvrplib": lambda r: bench_markdown(
            r, "CVRPLIB sets A, E and X (X: robots free), deadline 10 seconds"
        ),
    }
    texts = [HEAD]
    for name, write in parts.items():
        path = results / f"{name}.json"
        if path.exists():
            texts.append(write(json.loads(path.read_text())))
    return "\n".join(texts)


GATES = """K = 1, M = 15 (25 from n = 10 on) unless said otherwise; qubits are the paper's. 1,000
shots, nothing repaired; random: uniform bit strings for `penalty` and `one-hot`, uniform plans for
the other mixers."""

BATCHES = """Files of Henn with 30 orders, 10 seconds, three seeds, timed beside other work on the
machine. `neal` and `random` are one loop, fed by a sampler and by random proposals (orders dealt to
trips, loads not looked at); `batching` is the classical search. What an arm proposed by itself
stands apart from what repair made of it; selections choose among batches of repaired plans.
Diversity: mean distance of pairs of proposals, 1 where no two orders share a trip in both.

**The sampler does not beat random proposals here**: up to half of its reads are plans (hardly any
at capacity 30 and 45) and no random one is, but repair finds plans as short from either, and random
proposals cost no time."""

VQE = """Table 2 of the paper, default options, ten seeds (each its own instance), 2,000 reads,
nothing repaired; random: uniform bit strings, exactly (the left one of the optimum, the right one
of a plan). Medians; seconds hold search and reads."""

LAYER = "Processor seconds on one thread, cost and mixers, same precision, one run after the other."

GRADIENTS = """n = 3 of table 2 (16 qubits), lightning.qubit, Adam at equal steps; apart: the
largest difference of the two histories."""

PLANS = """Ten seeds a size, those that have a plan; a read counts before any repair. `dwave-qpu`
has simulated annealing (5000 sweeps) on an embedded Pegasus graph in place of the QPU, up to 8
jobs."""


def section(r: dict[str, Any], title: str, source: str, note: str) -> str:
    """Return a part that brings its own table."""
    return f"## {title}\n\n{host(r)} `{source}`\n\n{note}\n\n{r['markdown']}"


def host(report: dict[str, Any]) -> str:
    m = report["machine"]
    return f"{m['processor']}, {m['cores']} cores, {m['memory_gb']} GB; Python {m['python']}."


def startup(r: dict[str, Any]) -> str:
    loaded = r["heavy_modules_loaded"]
    ratio = f"{r['help_seconds']:.3f} s / {r['click_seconds']:.3f} s = {r['help_over_click']:.2f}"
    return f"""## Starting up

{host(r)}

| what | measured |
|---|--:|
| `qrobot --help` / `python -c "import click"` | {ratio} |
| `import qrobot` | {r["import_seconds"]:.3f} s |
| heavy modules that `import qrobot` loads | {"none" if loaded == "[]" else loaded} |
| building the reduced model, n = 12, K = 3 | {r["build_ms_n12_k3_reduced"]:.1f} ms |
| peak memory of `qrobot solve` on the example | {r["example_peak_mb"]:.0f} MB |
| the same with JSON, SVG and PNG written | {r["example_with_picture_peak_mb"]:.0f} MB |
"""


def paper(r: dict[str, Any]) -> str:
    return f"""## Paper-shaped random instances

{host(r)} n = 2 to 12 items, K = 1 to 4 robots, M = max(heaviest, ceil(1.1 W / K)); held against a
subset dynamic programme that shares no code with the package (`tests/oracles.py`).

| what | measured |
|---|--:|
| instances | {r["instances"]} |
| equal to the subset programme | {r["equal"]} |
| proven (optimal, or that no plan exists) | {r["proven"]} ({r["infeasible"]} without a plan) |
| median | {1000 * r["median_seconds"]:.1f} ms |
| worst | {1000 * r["worst_seconds"]:.0f} ms |
"""


def raw(r: dict[str, Any]) -> str:
    return "\n".join(["## What `neal` finds by itself", "", host(r), "", r["markdown"]])
