"""What it costs to start: help, imports, building a model, and the memory of one plan.

    PYTHONPATH=tests python -m benchmarks.startup --json build/bench/startup.json

Every time is the least of several fresh processes, given beside its peer from the same run.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.outputs import write

ROOT = Path(__file__).resolve().parent.parent
HEAVY = ("qiskit", "pennylane", "braket", "numba", "matplotlib", "ortools", "pandas", "scipy")


def seconds(*command: str, repeat: int = 9) -> float:
    """Return the least wall-clock time of a command."""
    found = []
    for _ in range(repeat):
        begun = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
        found.append(time.perf_counter() - begun)
    return min(found)


def peak_mb(*command: str) -> float:
    """Return the peak resident memory of a command, 10^6 bytes."""
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{command} ended with {process.returncode}")
    return usage.ru_maxrss * 1024 / 1e6


def build_milliseconds() -> float:
    """Return the least time to build the reduced model of n = 12, K = 3."""
    from oracles import paper_shaped

    from qrobot.models import build_model

    instance = paper_shaped(12, 3, 0)
    _ = instance.distances, instance.weights
    found = []
    for _ in range(20):
        begun = time.perf_counter()
        build_model(instance, encoding="reduced")
        found.append(time.perf_counter() - begun)
    return 1000 * min(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    python = sys.executable
    command = str(Path(python).parent / "qrobot")
    run = [command] if Path(command).exists() else [python, "-m", "qrobot"]
    loaded = subprocess.run(
        [python, "-c", f"import qrobot, sys; print([m for m in {HEAVY} if m in sys.modules])"],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    ).stdout.strip()
    help_seconds = seconds(*run, "--help")
    click_seconds = seconds(python, "-c", "import click")
    example = [*run, "solve", "examples/small-warehouse.json", "-t", "5"]
    report = {
        "what": "starting up",
        "help_seconds": help_seconds,
        "click_seconds": click_seconds,
        "help_over_click": help_seconds / click_seconds,
        "import_seconds": seconds(python, "-c", "import qrobot"),
        "heavy_modules_loaded": loaded,
        "build_ms_n12_k3_reduced": build_milliseconds(),
        "example_peak_mb": peak_mb(*example),
        "example_with_picture_peak_mb": peak_mb(
            *example, "-o", "build/bench/plan.json", "-p", "build/bench/plan.svg", "-p",
            "build/bench/plan.png",
        ),
    }  # fmt: skip
    write(report, arguments.json)
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
