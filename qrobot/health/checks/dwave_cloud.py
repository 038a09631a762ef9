"""D-Wave's cloud client: a problem as it goes over the wire, and an answer from it, offline."""

import base64
import math
import struct
from types import SimpleNamespace
from typing import Any

from qrobot.health.check import Check

QUBITS = (0, 1, 2, 4, 5, 7)
COUPLERS = ((0, 1), (0, 4), (1, 5), (2, 7), (4, 5))
LINEAR = {0: 0.5, 1: -1.25, 5: 2.0}
QUADRATIC = {(0, 1): -1.0, (1, 5): 0.75}
STATES, ENERGIES, COUNTS = ((1, -1, 1), (-1, -1, 1)), (-3.5, -1.25), (7, 3)


def answer() -> list[float]:
    """Return the numbers that are sent, with 99 for an unused qubit, and those understood."""
    from dwave.cloud import coders

    solver = SimpleNamespace(_encoding_qubits=QUBITS, _encoding_couplers=COUPLERS)
    sent = coders.encode_problem_as_qp(solver, LINEAR, QUADRATIC)
    numbers = [*_doubles(sent["lin"]), *_doubles(sent["quad"])]
    bits = bytes(sum((s > 0) << (7 - k) for k, s in enumerate(state)) for state in STATES)
    reads = {
        "format": "qp",
        "num_variables": 8,
        "active_variables": _packed("i", sorted(LINEAR)),
        "energies": _packed("d", ENERGIES),
        "num_occurrences": _packed("i", COUNTS),
        "solutions": base64.b64encode(bits).decode(),
    }
    got = coders.decode_qp_numpy({"type": "ising", "answer": reads}, return_matrix=False)
    return [
        *(99.0 if math.isnan(number) else number for number in numbers),
        *got["energies"],
        *got["num_occurrences"],
        *(state[qubit] for state in got["solutions"] for qubit in sorted(LINEAR)),
    ]


def expected() -> list[float]:
    """Return the terms in the solver's sequence, of used qubits; then what was packed."""
    linear = [LINEAR.get(qubit, 99.0) for qubit in QUBITS]
    quadratic = [QUADRATIC.get(pair, 0.0) for pair in COUPLERS if set(pair) <= set(LINEAR)]
    return [*linear, *quadratic, *ENERGIES, *COUNTS, *(spin for state in STATES for spin in state)]


def _doubles(text: str) -> tuple[float, ...]:
    data = base64.b64decode(text)
    return struct.unpack(f"<{len(data) // 8}d", data)


def _packed(kind: str, numbers: Any) -> str:
    return base64.b64encode(struct.pack(f"<{len(numbers)}{kind}", *numbers)).decode()


CHECK = Check(
    __name__,
    title="problem and answer on the wire",
    group="annealing",
    imports=("dwave.cloud", "dwave.cloud.coders"),
    distributions=("dwave-cloud-client",),
    source="the format qp of D-Wave's interface, packed by the standard library",
    extra="dwave",
)
