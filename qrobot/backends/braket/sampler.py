"""VQE and QAOA on Amazon Braket: the local simulator, and any managed device.

Variable k is qubit k in circuits. Braket counts qubit 0 as the highest bit of an index, so
exact probabilities are taken from a circuit in which variable k is qubit n - 1 - k.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot._extras import load
from qrobot.backends.braket.devices import arn_of, check_status, open_device
from qrobot.backends.braket.tasks import TaskEngine, check_fit
from qrobot.backends.gate.circuit import TURNING, Circuit, lowered
from qrobot.backends.gate.engine import Engine, StateEngine, attempt, room
from qrobot.backends.gate.form import terms
from qrobot.backends.gate.sampler import VariationalSampler
from qrobot.backends.gate.search import Options
from qrobot.backends.sampler import Parameter
from qrobot.errors import InputError
from qrobot.jobs import JobOptions

__all__ = ["BraketQAOA", "BraketVQE", "circuit_of", "observable"]


NAMES = {
    ("rzz", 0): "zz", ("phase", 0): "phaseshift", ("phase", 1): "cphaseshift", ("x", 1): "cnot",
    ("x", 2): "ccnot", ("swap", 1): "cswap",
}  # fmt: skip
"""Braket's name of a gate with so many controls, where it is not ours. Control modifiers are not
used: managed devices refuse them."""


def observable(bqm: Any) -> Any:
    """Return a model's Ising form as a Braket observable (a sum of Z words).

    `braket_sv` rejects sums as result types (STACK): the samplers evaluate the diagonal
    themselves; the sum is for devices that take it.

    Parameters
    ----------
    bqm
        A dimod model; qubit k is the k-th variable, state 1 is x = 1 (dimod: s = +1).
    """
    observables = load("braket.circuits.observables", "Braket observables")
    made = []
    for value, qubits in terms(bqm):
        if not qubits:
            word = observables.I(0) if bqm.num_variables else observables.I()
        else:
            word = observables.Z(qubits[0])
            for q in qubits[1:]:
                word = word @ observables.Z(q)
        made.append(value * word)
    return made[0] if len(made) == 1 else observables.Sum(made)


def circuit_of(
    circuit: Circuit, angles: Iterable[float] = (), *, reverse: bool = False, native: bool = True
) -> Any:
    """Return a Braket circuit.

    Parameters
    ----------
    circuit, angles
        What to translate; one number a searched rotation.
    reverse
        Whether variable k is qubit n - 1 - k and not qubit k.
    native
        Whether ZZ rotations may stay one gate: simulators and trapped ions have it, other
        chips get two CNOTs.
    """
    made = load("braket.circuits", "Braket circuits").Circuit()
    last = circuit.qubits - 1
    if any(gate.controls for gate in circuit.gates):
        circuit = lowered(circuit)
        for qubit in range(circuit.qubits):
            made.i(qubit)  # so that every qubit is there, used or not
    for gate, angle in circuit.turned(angles):
        qubits = [last - q if reverse else q for q in (*gate.controls, *gate.qubits)]
        if gate.name == "rzz" and not native:
            made.cnot(*qubits).rz(qubits[1], angle).cnot(*qubits)
            continue
        given = (angle,) if gate.name in TURNING else ()
        name = NAMES.get((gate.name, len(gate.controls)), gate.name)
        getattr(made, name)(*qubits, *given)
    return made


class _Local(StateEngine):
    """Exact probabilities of Braket's local state vector simulator."""

    def __init__(self, circuit: Circuit, name: str) -> None:
        super().__init__(circuit)
        devices = load("braket.devices", "backend braket")
        self._device = devices.LocalSimulator(name)
        self.facts = {"device": name}

    def probabilities(self, angles: Floats) -> Floats:
        self.executions += 1
        made = circuit_of(self.circuit, angles, reverse=True).probability()
        result = self._device.run(made, shots=0).result()
        return np.asarray(result.values[0], dtype=np.float64)


class _Shots(Engine):
    """Measured shots of a simulator of this machine."""

    def __init__(self, circuit: Circuit, device: Any, run: dict[str, Any]) -> None:
        super().__init__(circuit)
        self._device, self._run = device, run
        self.facts = {"device": str(getattr(device, "name", type(device).__name__))}

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots; Braket's devices take no seed."""
        self.executions += 1
        del seed
        made = circuit_of(self.circuit, angles)
        result = attempt(
            "braket",
            "running the circuit",
            lambda: self._device.run(made, shots=shots, **self._run).result(),
        )
        found = np.asarray(result.measurements, dtype=np.int8)
        order = [list(result.measured_qubits).index(q) for q in range(self.circuit.qubits)]
        return found[:, order]


class _Braket(VariationalSampler):
    """Both algorithms on Braket.

    ``device``: ``local`` (default; also ``braket_sv`` or ``braket_dm``), an ARN, a name of
    `qrobot.backends.braket.devices` (SV1, DM1, Forte-1, Garnet, Emerald,
    Cepheus-1-108Q ...), or a device object. ``device_options``: for ``AwsDevice``, such as
    ``aws_session``. ``run_options``: passed to the device's ``run``, such as
    ``s3_destination_folder``. Credentials are boto3's own.
    """

    sdk = "braket"
    own: ClassVar[dict[str, Parameter]] = {"run_options": Parameter("names")}

    def check(self, qubits: int, options: Options) -> bool:
        load("braket.circuits", f"backend {self.name}")
        device = options.device or "local"
        if not isinstance(device, str) or device in ("local", "braket_sv", "braket_dm"):
            options.refuse_device_options("a device of this machine or a device object")
        if device in ("local", "braket_sv"):
            room(qubits, "Braket's local simulator")
            return True
        if device == "braket_dm":
            room(2 * qubits, f"Braket's local simulator (density matrix of {qubits} qubits)")
            return True
        if isinstance(device, str):
            arn_of(device)
            return False
        if not callable(getattr(device, "run", None)):
            raise InputError(f"a {type(device).__name__} is not a Braket device", field="device")
        if getattr(device, "arn", None):
            return False
        room(qubits, "Braket's local simulator")
        return True

    def engine(self, circuit: Circuit, options: Options) -> Engine:
        device, run = options.device or "local", dict(options.own.get("run_options") or {})
        if isinstance(device, str):
            name = "braket_sv" if device == "local" else device
            if options.shots is None:
                return _Local(circuit, name)
            device = load("braket.devices", "backend braket").LocalSimulator(name)
        return _Shots(circuit, device, run)

    def connect(self, qubits: int, options: Options, job_options: JobOptions) -> Any:
        """Return an ``AwsDevice`` that holds the model and is online."""
        device = options.device
        if isinstance(device, str):
            arn = arn_of(device)
            load("braket.aws", "Braket's managed devices")
            device = open_device(arn, options.device_options, job_options)
        else:
            check_status(device)
        shots = int(options.num_reads)
        if options.train == "device":
            shots = max(shots, options.shots or 0)
        check_fit(device, qubits, shots)
        return device

    def remote_engine(self, machine: Any, circuit: Circuit, options: Options) -> TaskEngine:
        def build(angles: Floats, native: bool) -> Any:
            return circuit_of(circuit, angles, native=native)

        return TaskEngine(circuit, machine, build, dict(options.own.get("run_options") or {}))


class BraketVQE(_Braket):
    """VQE on Braket (backend ``braket-vqe``)."""

    algorithm = "vqe"


class BraketQAOA(_Braket):
    """QAOA on Braket (backend ``braket-qaoa``)."""

    algorithm = "qaoa"
