"""Plans and reads of every local backend, made on two machines and held against each other.

    plans.py make FILE         solve the small examples with every local backend, keep it all
    plans.py compare A B       of two such files; evaluates all energies anew; exit code 1: differs

Run inside the images: `make` on each of them, `compare` on one. Work is limited by evaluations
and never by the clock, so that a slow machine does the same work.
"""

from __future__ import annotations

import json
import platform
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

QUESTIONS = {
    "exact": "paper-4-items",
    "batching": "small-warehouse",
    "pyvrp": "tiny",
    "pyvrp-plain": "tiny",
}
"""Planners get something to plan; the three items of the others fit into 9 qubits."""

WORK = {"exact": 100_000, "batching": 300, "pyvrp": 200, "pyvrp-plain": 200}
"""Units of work of each planner."""

OPTIONS: dict[str, dict[str, Any]] = {
    "neal": {"num_reads": 100},
    "tabu": {"num_reads": 10},
    "descent": {"num_reads": 100},
    "statevector": {"num_reads": 200},
}
"""What samplers get; gate-model ones that search get few evaluations."""

READS, EVALUATIONS = 200, 4

KERNELS = "qrobot.backends.classical.batching.annealing"
"""The module of the compiled search of whole orders; the plain search does not import it."""


def make(file: Path) -> None:
    """Solve with every local backend that is installed."""
    from qrobot.backends import registry

    answers = {}
    for name in registry.names():
        facts = registry.capabilities(name)
        if not facts.local or not registry.available(name):
            continue
        begun = time.monotonic()
        answers[name] = _plan(name) if facts.kind == "planner" else _reads(name)
        answers[name]["seconds"] = round(time.monotonic() - begun, 2)
        print(f"{name}: {answers[name]['seconds']} s", file=sys.stderr, flush=True)
    document = {
        "machine": platform.machine(),
        "python": platform.python_version(),
        "search": "compiled" if KERNELS in sys.modules else "plain",
        "backends": answers,
    }
    file.write_text(json.dumps(document, indent=1))


def _question(name: str) -> Any:
    from qrobot.problem.formats import read

    return read(f"example:{QUESTIONS.get(name, 'three-items')}")


def _plan(name: str) -> dict[str, Any]:
    from qrobot.planning import solve

    result = solve(_question(name), backend=name, max_work=WORK.get(name, 50), seed=1)
    plan = result.plan.to_dict()
    return {"kind": "planner", "cost": result.cost, "plan": plan}


def _reads(name: str) -> dict[str, Any]:
    """Sample once: neither repaired nor polished."""
    from qrobot.backends import registry
    from qrobot.models import build_model

    sampler: Any = registry.get(name)
    model = build_model(_question(name), encoding="compact")
    known = sampler.parameters
    options = dict(OPTIONS.get(name, {"num_reads": READS}))
    if "evaluations" in known:
        options["evaluations"] = EVALUATIONS
    if "seed" in known:
        options["seed"] = 1
    samples = sampler.sample(model.bqm, **options)
    rows = np.asarray(model.matrix(samples))
    feasible, costs = model.decode_all(samples)[:2]
    good = [float(cost) for cost, fits in zip(costs, feasible, strict=True) if fits]
    return {
        "kind": "sampler",
        "bits": ["".join(map(str, row)) for row in rows],
        "counts": samples.record.num_occurrences.tolist(),
        "energies": samples.record.energy.tolist(),
        "cost": min(good) if good else None,
    }


def compare(first: Path, second: Path) -> int:
    """Print one line a backend; return 1 when the machines disagree."""
    from qrobot.backends import registry

    one, two = json.loads(first.read_text()), json.loads(second.read_text())
    here = filter(registry.available, registry.names())
    wanted = {name for name in here if registry.capabilities(name).local}
    names = sorted(wanted | one["backends"].keys() | two["backends"].keys())
    print(f"{'backend':<16} {one['machine']:>10} {two['machine']:>10}  verdict")
    searches = [document.get("search", "unknown") for document in (one, two)]
    bad = int(searches[0] != searches[1])
    verdict = "DIFFERENT: compiled kernels on one machine only" if bad else "the same search"
    print(f"{'(whole orders)':<16} {searches[0]:>10} {searches[1]:>10}  {verdict}")
    for name in names:
        a, b = one["backends"].get(name), two["backends"].get(name)
        if a is None or b is None:
            verdict, fine = f"missing on {'both' if a is b else 'one'}", False
        elif a["kind"] == "planner":
            fine = a["plan"] == b["plan"]
            verdict = "identical plans" if fine else "the plans differ"
        else:
            fine, verdict = _same_energies(name, a, b)
        costs = [f"{x['cost']:.4f}" if x and x["cost"] is not None else "-" for x in (a, b)]
        print(f"{name:<16} {costs[0]:>10} {costs[1]:>10}  {verdict}")
        bad += not fine
    return 1 if bad else 0


def _same_energies(name: str, a: dict[str, Any], b: dict[str, Any]) -> tuple[bool, str]:
    """Evaluate all reads of both machines here, by the definition of the energy."""
    from qrobot.models import build_model

    model = build_model(_question(name), encoding="compact")
    linear = np.array([model.bqm.get_linear(v) for v in model.variables])
    place = {v: k for k, v in enumerate(model.variables)}
    worst, fine = 0.0, True
    for answer in (a, b):
        bits = np.array([[int(bit) for bit in row] for row in answer["bits"]], dtype=float)
        energy = float(model.bqm.offset) + bits @ linear
        for (u, v), value in model.bqm.quadratic.items():
            energy = energy + value * bits[:, place[u]] * bits[:, place[v]]
        gaps = np.abs(energy - np.array(answer["energies"]))
        worst = float(np.max([worst, gaps.max()]))  # keeps a nan
        fine = fine and bool((gaps <= 1e-9).all())
    same = sorted(zip(a["bits"], a["counts"], strict=True)) == sorted(
        zip(b["bits"], b["counts"], strict=True)
    )
    return fine, ("" if fine else "WRONG: ") + (
        f"{len(a['bits'])} and {len(b['bits'])} reads re-evaluate to {worst:.0e}"
        f"{', the same reads' if same else ', other reads'}"
    )


def main() -> int:
    if len(sys.argv) == 3 and sys.argv[1] == "make":
        make(Path(sys.argv[2]))
        return 0
    if len(sys.argv) == 4 and sys.argv[1] == "compare":
        return compare(Path(sys.argv[2]), Path(sys.argv[3]))
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
