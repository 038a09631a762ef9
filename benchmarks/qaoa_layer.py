"""One QAOA layer on a complete graph: ours beside Aer, lightning and plain numpy.

    python -m benchmarks.qaoa_layer --json build/bench/qaoa-layer.json \
        --markdown build/bench/qaoa-layer.md

One thread for everybody, in one process, turn by turn, the best of some repeats; wall-clock and
processor seconds both, because only the latter mean anything on a machine that others use.

- ours: `begin`, the phase by the diagonal and all mixers on the uniform state, and `layer`, the
  same on any state; the slower of the two counts.
- plain numpy: the diagonal, `np.exp`, and one reshaped pass a qubit on a complex array.
- Aer, lightning: the circuit H, RZ, RZZ, RX less the circuit H alone, each with its cheapest
  result; gates are fused as they like.

Before anything is timed, all must agree on the probabilities (n = 10).
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import dimod
import numpy as np

from benchmarks.outputs import write
from qrobot.backends.gate.form import Form, diagonal
from qrobot.backends.gate.resources import pair
from qrobot.backends.gate.state.engine import make_engine
from qrobot.study.render import markdown_table

GAMMA, BETA = 0.1, -0.4
DTYPES = {"double": np.float64, "single": np.float32}

Timed = tuple[float, float]


def clock(work: Callable[[], Any]) -> Timed:
    """Return wall-clock and processor seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - cpu


def complete(qubits: int) -> Form:
    """Return a complete graph with random fields and couplings."""
    bqm = dimod.generators.gnp_random_bqm(qubits, 1.0, "SPIN", random_state=qubits)
    return Form.from_bqm(bqm)


class Ours:
    """The diagonal simulator with one of its engines."""

    def __init__(self, form: Form, precision: str, engine: str) -> None:
        dtype = DTYPES[precision]
        self.engine = make_engine(engine, 1)
        self.diagonal = diagonal(form, dtype)
        self.re, self.im = pair(1 << form.qubits, dtype)
        self.engine.begin(self.re, self.im, self.diagonal, GAMMA, BETA)

    def time(self) -> Timed:
        both = [
            clock(lambda run=run: run(self.re, self.im, self.diagonal, GAMMA, BETA))
            for run in (self.engine.layer, self.engine.begin)
        ]
        return max(b[0] for b in both), max(b[1] for b in both)

    def probabilities(self) -> np.ndarray:
        return self.re.astype(float) ** 2 + self.im.astype(float) ** 2


class Numpy:
    """What everybody writes first."""

    def __init__(self, form: Form, precision: str) -> None:
        kind = np.complex128 if precision == "double" else np.complex64
        self.diagonal = diagonal(form, DTYPES[precision])
        self.state = np.full(1 << form.qubits, (1 << form.qubits) ** -0.5, dtype=kind)
        self.qubits, self.kind = form.qubits, kind
        self.layer()

    def layer(self) -> None:
        self.state *= np.exp(self.kind(-1j * GAMMA) * self.diagonal)
        c, s = self.kind(np.cos(BETA)), self.kind(-1j * np.sin(BETA))
        for q in range(self.qubits):
            pair = self.state.reshape(-1, 2, 1 << q)
            low, high = pair[:, 0].copy(), pair[:, 1].copy()
            pair[:, 0] = c * low + s * high
            pair[:, 1] = s * low + c * high

    def time(self) -> Timed:
        return clock(self.layer)

    def probabilities(self) -> np.ndarray:
        return np.abs(self.state.astype(complex)) ** 2


class Aer:
    """qiskit-aer's statevector method."""

    def __init__(self, form: Form, precision: str) -> None:
        from qiskit import QuantumCircuit
        from qiskit_aer import AerSimulator

        h, J, _ = form.ising
        n = form.qubits
        self.simulator = AerSimulator(
            method="statevector", precision=precision, max_parallel_threads=1
        )
        self.start = QuantumCircuit(n)
        self.start.h(range(n))
        self.whole = self.start.copy()
        for i in range(n):
            self.whole.rz(2 * GAMMA * h[i], i)
            for j in range(i):
                self.whole.rzz(2 * GAMMA * J[i, j], j, i)
        for i in range(n):
            self.whole.rx(2 * BETA, i)
        self.state = self.whole.copy()
        self.state.save_probabilities()
        for circuit in (self.start, self.whole):
            circuit.save_probabilities([0])

    def time(self) -> Timed:
        start, whole = (clock(lambda c=c: self._run(c)) for c in (self.start, self.whole))
        return whole[0] - start[0], whole[1] - start[1]

    def _run(self, circuit: Any) -> Any:
        result = self.simulator.run(circuit, shots=1).result()
        assert result.success, result.status
        return result

    def probabilities(self) -> np.ndarray:
        return np.asarray(self._run(self.state).data()["probabilities"])


class Lightning:
    """PennyLane's lightning.qubit."""

    def __init__(self, form: Form, precision: str) -> None:
        import pennylane as qml

        h, J, _ = form.ising
        n = form.qubits
        kind = np.complex128 if precision == "double" else np.complex64
        device = qml.device("lightning.qubit", wires=n, c_dtype=kind)

        def gates(layers: int) -> None:
            for i in range(n):
                qml.Hadamard(i)
            if layers:
                for i in range(n):
                    qml.RZ(2 * GAMMA * h[i], i)
                    for j in range(i):
                        qml.IsingZZ(2 * GAMMA * J[i, j], [j, i])
                for i in range(n):
                    qml.RX(2 * BETA, i)

        @qml.qnode(device)
        def one(layers: int) -> Any:
            gates(layers)
            return qml.expval(qml.PauliZ(0))

        @qml.qnode(device)
        def every() -> Any:
            gates(1)
            return qml.probs(wires=range(n))

        self.run, self.every = one, every

    def time(self) -> Timed:
        start, whole = (clock(lambda layers=layers: self.run(layers)) for layers in (0, 1))
        return whole[0] - start[0], whole[1] - start[1]

    def probabilities(self) -> np.ndarray:
        found = np.asarray(self.every())
        n = found.size.bit_length() - 1
        return found.reshape((2,) * n).transpose(range(n)[::-1]).reshape(-1)  # wire 0 is highest


METHODS: dict[str, Callable[[Form, str], Any]] = {
    "ours, numba": lambda form, precision: Ours(form, precision, "numba"),
    "ours, numpy": lambda form, precision: Ours(form, precision, "numpy"),
    "Aer": Aer,
    "lightning": Lightning,
    "plain numpy": Numpy,
}


def measure(sizes: list[int], repeats: int, methods: list[str]) -> list[dict[str, Any]]:
    """Return a row for each size and precision."""
    rows = []
    for n in sizes:
        form = complete(n)
        for precision in DTYPES:
            # One after the other in memory, round after round in time.
            found: dict[str, list[Timed]] = {name: [] for name in methods}
            for _ in range(repeats):
                for name in methods:
                    found[name].append(METHODS[name](form, precision).time())
            row: dict[str, Any] = {"qubits": n, "precision": precision}
            for name, times in found.items():
                row[name] = {"wall": min(t[0] for t in times), "cpu": min(t[1] for t in times)}
            rows.append(row)
            shown = "  ".join(f"{name} {row[name]['cpu']:.4f}" for name in methods)
            print(f"n={n} {precision}: {shown}", file=sys.stderr, flush=True)
    return rows


def agreement(methods: list[str]) -> dict[str, float]:
    """Return the largest difference of probabilities from plain numpy at 10 qubits."""
    form = complete(10)
    expected = Numpy(form, "double").probabilities()
    found = {}
    for name in methods:
        for precision, near in (("double", 1e-12), ("single", 1e-5)):
            one = METHODS[name](form, precision)
            far = float(np.abs(one.probabilities() - expected).max())
            assert far < near, f"{name}, {precision}: off by {far}"
            found[f"{name}, {precision}"] = far
    return found


def as_markdown(rows: list[dict[str, Any]], methods: list[str]) -> str:
    """Return processor seconds as a table, and how many times Aer takes ours."""
    lines = []
    for row in rows:
        cells = [f"{row[name]['cpu']:.4f}" for name in methods]
        ratio = ["-", "-"]
        if "Aer" in row and "ours, numba" in row:
            ratio = [f"{row['Aer'][k] / row['ours, numba'][k]:.1f}" for k in ("cpu", "wall")]
        lines.append([str(row["qubits"]), row["precision"], *cells, *ratio])
    heads = ["qubits", "precision", *methods, "Aer / ours, cpu", "wall"]
    return "\n".join(markdown_table(heads, lines, left={1})) + "\n"


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--qubits", type=int, nargs="+", default=[16, 20, 22, 24])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--methods", nargs="+", choices=list(METHODS), default=list(METHODS))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    arguments = parser.parse_args()
    agreed = agreement(arguments.methods)
    load = os.getloadavg()[0]
    rows = measure(arguments.qubits, arguments.repeats, arguments.methods)
    table = as_markdown(rows, arguments.methods)
    report = {
        "what": "one QAOA layer, one thread, seconds",
        "architecture": platform.machine(),
        "load_before": load,
        "agreement": agreed,
        "rows": rows,
        "markdown": table,
    }
    write(report, arguments.json, arguments.markdown)
    print(table)


if __name__ == "__main__":
    main()
