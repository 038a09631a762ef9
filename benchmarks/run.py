"""Measure on this machine and write docs/benchmarks.md anew: `make bench`.

    python -m benchmarks.run                 # everything (about half an hour)
    python -m benchmarks.run --only startup,paper
    python -m benchmarks.run --pages         # write the page from the results that are there

Each part writes benchmarks/results/PART.json; the page is made from those files alone. The
instances of QOBLIB, CVRPLIB and Henn are not part of the project: their parts run where the folder
`--data` (default ../shared/data) holds them. Let nothing else run meanwhile.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results"
PAGE = ROOT / "docs" / "benchmarks.md"


from benchmarks.pages import page
from qrobot.study.runner import machine


def keep(name: str, report: dict[str, Any]) -> None:
    RESULTS.mkdir(exist_ok=True)
    report.setdefault("machine", machine())
    (RESULTS / f"{name}.json").write_text(json.dumps(report, indent=1) + "\n")


def script(name: str, *arguments: str) -> dict[str, Any]:
    """Run one of the scripts beside this one and return what it measured."""
    out = ROOT / "build" / "bench" / f"{name}.json"
    out.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        [sys.executable, "-m", f"benchmarks.{name}", *arguments, "--json", str(out)],
        check=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT / "tests")},  # oracles.py and others
    )
    loaded: dict[str, Any] = json.loads(out.read_text())
    return loaded


def bench(folder: Path, *arguments: str) -> dict[str, Any]:
    """Run `qrobot bench` and return its report."""
    out = ROOT / "build" / "bench" / f"{folder.name}.json"
    out.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        [sys.executable, "-m", "qrobot", "bench", str(folder), *arguments, "--json", str(out)],
        cwd=ROOT,
        check=False,  # an instance without a plan is a row, and a result
    )
    loaded: dict[str, Any] = json.loads(out.read_text())
    return loaded


def parts(data: Path) -> dict[str, Callable[[], dict[str, Any]]]:
    found: dict[str, Callable[[], dict[str, Any]]] = {
        "startup": lambda: script("startup"),
        "paper": lambda: script("paper_shaped"),
        "raw": lambda: script("raw_sampling"),
        "examples": lambda: bench(ROOT / "examples", "--backends", "auto,batching,neal", "-t", "5"),
    }
    if _installed("numba"):
        found["gates"] = lambda: script("gate_rows")
    if _installed("qiskit_aer", "pennylane_lightning", "braket.devices"):
        found["layer"] = lambda: script("qaoa_layer")
        found["gradients"] = lambda: script("pennylane_gradients")
        found["vqe"] = lambda: script("vqe_rows", "--first", "100")
    if _installed("dwave.system"):
        found["plans"] = lambda: script("feasible_reads")
    if _installed("numba") and (henn := data / "picking" / "henn").is_dir():
        found["batches"] = lambda: script("hybrid_batches", "--data", str(henn))
    if (data / "qoblib").is_dir():
        found["qoblib"] = lambda: bench(
            data / "qoblib", "--backends", "auto,pyvrp", "-t", "10", "--robots", "4"
        )
    if (data / "cvrplib").is_dir():
        found["cvrplib"] = lambda: bench(
            data / "cvrplib", "--backends", "auto,pyvrp", "-t", "10", "--robots-for", "X-*=free"
        )
    return found


def _installed(*modules: str) -> bool:
    try:
        return all(importlib.util.find_spec(module) for module in modules)
    except ModuleNotFoundError:
        return False


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="parts, with commas")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--pages", action="store_true", help="measure nothing, write the page")
    arguments = parser.parse_args()
    todo = parts(arguments.data)
    if arguments.pages:
        todo = {}
    elif arguments.only:
        todo = {name: todo[name] for name in arguments.only.split(",")}
    for name, run in todo.items():
        print(f"== {name}", flush=True)
        keep(name, run())
    PAGE.write_text(page(RESULTS))
    print(f"written: {PAGE}")


if __name__ == "__main__":
    main()
