"""What the paper prints: rows, qubits and seconds of its tables 1 to 3."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

__all__ = ["DEVICES", "TITLE", "YEAR", "PaperRow", "paper_rows"]

TITLE = (
    "qRobot: A Quantum computing approach in mobile robot order picking and batching problem "
    "solver optimization"
)
YEAR = 2021

DEVICES = {
    "dwave": "D-Wave (the caption calls all columns public simulators)",
    "braket_advantage_with_latency": (
        "D-Wave Advantage_system1 by Amazon Braket, waiting, queue and return included"
    ),
    "braket_advantage_run_only": "D-Wave Advantage_system1 by Amazon Braket, running time only",
    "ibmq_qasm_simulator": "ibmq_qasm_simulator by Qiskit",
    "pennylane": "PennyLane simulator",
}
"""The columns of ``paper.csv`` and the devices that the paper names for them."""


@dataclass(frozen=True, slots=True)
class PaperRow:
    """A row of one of the paper's tables.

    Parameters
    ----------
    table
        1, 2 or 3.
    robots, items, capacity
        K, n and M as printed.
    qubits
        As printed.
    seconds
        The paper's seconds by column of `DEVICES`; columns in which it prints "-" are left
        out.
    """

    table: int
    robots: int
    items: int
    capacity: int
    qubits: int
    seconds: dict[str, float]

    @property
    def encoding(self) -> Literal["full", "reduced"]:
        """The encoding that has the printed number of qubits."""
        return "full" if self.table == 1 else "reduced"

    @property
    def annealer(self) -> float | None:
        """The paper's seconds in the column of the annealer."""
        return next((s for c, s in self.seconds.items() if c.startswith(("dw", "braket"))), None)


@cache
def paper_rows(table: int) -> tuple[PaperRow, ...]:
    """Return the rows of a table, by number of items.

    Source: the tables of the paper (`TITLE`, `YEAR`), copied into ``paper.csv``. Table 3
    prints the gate columns of table 2 once more.
    """
    text = Path(__file__).with_name("paper.csv").read_text(encoding="utf-8")
    seconds: dict[tuple[int, int, int, int], dict[str, float]] = {}
    for line in csv.DictReader(text.splitlines()):
        if int(line["table"]) == table:
            names = ("robots", "items", "capacity", "qubits")
            key = tuple(int(line[name]) for name in names)
            seconds.setdefault(key, {})[line["column"]] = float(line["seconds"])  # type: ignore[arg-type]
    return tuple(PaperRow(table, *key, found) for key, found in sorted(seconds.items()))
