"""Our methods for a row of the paper: which can run, and how each is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from qrobot.study.reproduce.instances import ENUMERATED
from qrobot.study.reproduce.outcome import Line
from qrobot.study.reproduce.paper import PaperRow
from qrobot.study.reproduce.question import Question

__all__ = ["ANNEALERS", "LARGE_QUBITS", "METHODS", "QUBITS", "VQES", "Method", "methods_for"]

ANNEALERS = ("neal", "tabu", "descent")
VQES = ("qiskit-vqe", "pennylane-vqe", "braket-vqe")

QUBITS, LARGE_QUBITS = 24, 26
"""Most qubits of the penalty form, as a matter of course and with ``--large``."""

VQE_QUBITS = 18

Run = Callable[[Line, Question, int, int], Line]


@dataclass(frozen=True, slots=True)
class Method:
    """A way to fill a cell of the paper's tables.

    Parameters
    ----------
    name
        As reported.
    backend
        What runs: a backend of ours, or the simulator of `qrobot.backends.gate`.
    label
        Column title.
    counterpart
        The paper's column that it stands beside, for the plot: ``annealer`` or ``gate``.
    """

    name: str
    backend: str
    label: str
    counterpart: str

    def run(self, line: Line, question: Question, reads: int, seed: int) -> Line:
        """Fill a line.

        Raises
        ------
        Left
            When the method cannot run here; carries the reason.
        MissingExtraError
            When its software is not installed.
        BackendError
            When it fails.
        """
        run: Run
        if self.name in ANNEALERS:
            from qrobot.study.reproduce.samplers import anneal as run
        elif self.name in VQES:
            from qrobot.study.reproduce.samplers import variational as run
        else:
            from qrobot.study.reproduce import exact_states

            run = getattr(exact_states, self.name)
        return run(line, question, reads, seed)

    def warm(self) -> None:
        """Import and compile what the method needs, outside of every clock."""
        if self.name in (*ANNEALERS, *VQES):
            from qrobot.study.reproduce.samplers import warm
        else:
            from qrobot.study.reproduce.exact_states import warm
        warm(self.backend)


METHODS = {
    one.name: one
    for one in (
        Method("neal", "neal", "simulated annealing", "annealer"),
        Method("tabu", "tabu", "tabu search", "annealer"),
        Method("descent", "descent", "steepest descent", "annealer"),
        Method("qiskit-vqe", "qiskit-vqe", "VQE, Qiskit", "gate"),
        Method("pennylane-vqe", "pennylane-vqe", "VQE, PennyLane", "gate"),
        Method("braket-vqe", "braket-vqe", "VQE, Braket", "gate"),
        Method("penalty", "gates", "QAOA, penalty form, p = 1", "gate"),
        Method("swap", "gates", "QAOA, swap mixer, p = 4", "gate"),
        Method("grover", "gates", "QAOA, Grover mixer, p = 10", "gate"),
    )
}


def methods_for(
    row: PaperRow, *, large: bool = False, quick: bool = False
) -> list[tuple[Method, str | None]]:
    """Return the methods of a row, each with the reason why it is left out, or None.

    The penalty form and VQE simulate all 2^qubits states; beyond their sizes the mixers that
    keep the constraints take over, which know the n! plans only: enumerated up to n = 9, then
    counted.
    """
    found: list[tuple[Method, str | None]] = [(METHODS[name], None) for name in ANNEALERS]
    if row.items <= 3:
        why = None
        if quick:
            why = "left out by --quick"
        elif row.qubits > VQE_QUBITS:
            why = f"VQE is run up to {VQE_QUBITS} qubits, these are {row.qubits}"
        found += [(METHODS[name], why) for name in VQES]
    if row.qubits <= LARGE_QUBITS:
        why = None
        if row.qubits > QUBITS and not large:
            why = f"{row.qubits} qubits are simulated with --large only"
        found.append((METHODS["penalty"], why))
    if row.qubits > QUBITS:
        found.append((METHODS["swap" if row.items <= ENUMERATED else "grover"], None))
    return found
