"""VQE and QAOA on Amazon Braket: the local simulator, and any managed device.

Variable k is qubit k in circuits. Braket counts qubit 0 as the highest bit of an index, so
exact probabilities are taken from a circuit in which variable k is qubit n - 1 - k.
"""

from __future__ import annotations

import importlib
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from qrobot.backends.variational.ansatz import Ansatz
from qrobot.backends.variational.circuit import Circuit
from qrobot.backends.variational.devices import arn_of
from qrobot.backends.variational.engine import Engine, StateEngine, room
from qrobot.backends.variational.ising import terms
from qrobot.backends.variational.options import Options
from qrobot.backends.variational.sampler import VariationalSampler, failed
from qrobot.errors import BackendError, CredentialsError, InputError, MissingExtraError

__all__ = ["BraketQAOA", "BraketVQE", "circuit_of", "observable"]

Floats = npt.NDArray[np.float64]
Bits = npt.NDArray[np.int8]

NAMES = {"rzz": "zz"}

SIMULATORS = ("sv1", "dm1")


def observable(bqm: Any) -> Any:
    """Return a model's Ising form as a Braket observable (a sum of Z words).

    `braket_sv` rejects sums as result types (STACK): the samplers evaluate the diagonal
    themselves; the sum is for devices that take it.

    Parameters
    ----------
    bqm
        A dimod model; qubit k is the k-th variable, state 1 is x = 1 (dimod: s = +1).
    """
    observables = _need("braket.circuits.observables", "Braket observables")
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
    circuit: Circuit, angles: Floats, *, reverse: bool = False, native: bool = True
) -> Any:
    """Return a Braket circuit.

    Parameters
    ----------
    circuit, angles
        What to translate; one number a rotation.
    reverse
        Whether variable k is qubit n - 1 - k and not qubit k.
    native
        Whether ZZ rotations may stay one gate: simulators and trapped ions have it, other
        chips get two CNOTs.
    """
    made = _need("braket.circuits", "Braket circuits").Circuit()
    last = circuit.qubits - 1
    for gate, angle in circuit.turned(angles):
        qubits = [last - q if reverse else q for q in gate.qubits]
        if gate.name == "rzz" and not native:
            made.cnot(*qubits).rz(qubits[1], angle).cnot(*qubits)
            continue
        given = (angle,) if gate.slot >= 0 else ()
        getattr(made, NAMES.get(gate.name, gate.name))(*qubits, *given)
    return made


class _Local(StateEngine):
    """Exact probabilities of Braket's local state vector simulator."""

    def __init__(self, circuit: Circuit, name: str) -> None:
        super().__init__(circuit)
        devices = _need("braket.devices", "backend braket")
        self._device = devices.LocalSimulator(name)
        self.facts = {"device": name}

    def probabilities(self, angles: Floats) -> Floats:
        """Return the probabilities of all assignments."""
        self.executions += 1
        made = circuit_of(self.circuit, angles, reverse=True).probability()
        result = self._device.run(made, shots=0).result()
        return np.asarray(result.values[0], dtype=np.float64)


class _Shots(Engine):
    """Measured shots of any Braket device."""

    def __init__(
        self, circuit: Circuit, device: Any, name: str, native: bool, run: dict[str, Any]
    ) -> None:
        super().__init__(circuit)
        self._device, self._native, self._run = device, native, run
        self.facts = {"device": name}

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots; Braket's devices take no seed."""
        self.executions += 1
        del seed
        made = circuit_of(self.circuit, angles, native=self._native)
        try:
            task = self._device.run(made, shots=shots, **self._run)
            self.facts.setdefault("jobs", []).append(str(getattr(task, "id", "")))
            result = task.result()
        except Exception as error:
            raise failed("braket", "running the circuit", error) from None
        if result is None or getattr(result, "measurements", None) is None:
            raise BackendError("backend braket: the task ended without measurements")
        found = np.asarray(result.measurements, dtype=np.int8)
        order = [list(result.measured_qubits).index(q) for q in range(self.circuit.qubits)]
        return found[:, order]


class _Braket(VariationalSampler):
    """Both algorithms on Braket.

    ``device``: ``local`` (default; also ``braket_sv`` or ``braket_dm``), an ARN, a name of
    `qrobot.backends.variational.devices` (SV1, DM1, Forte-1, Garnet, Emerald,
    Cepheus-1-108Q ...), or a device object. ``run_options``: passed to the device's ``run``,
    such as ``s3_destination_folder``. Credentials are boto3's own.
    """

    sdk = "braket"
    extra = "braket"
    own: ClassVar[tuple[str, ...]] = ("run_options",)

    def check(self, qubits: int, options: Options, own: dict[str, Any]) -> bool:
        """Refuse what does not fit; True for devices of this machine."""
        del own
        _need("braket.circuits", f"backend {self.name}")
        device = options.device or "local"
        if device in ("local", "braket_sv"):
            room(qubits, "Braket's local simulator")
            return True
        if device == "braket_dm":
            room(2 * qubits, f"Braket's local simulator (density matrix of {qubits} qubits)")
            return True
        if isinstance(device, str):
            arn_of(device)
        elif not callable(getattr(device, "run", None)):
            raise InputError(f"a {type(device).__name__} is no Braket device", field="device")
        else:
            _fits(device, qubits)
        return False

    def engine(self, ansatz: Ansatz, options: Options, own: dict[str, Any]) -> Engine:
        """Return the device, ready to run the ansatz."""
        device, run = options.device or "local", dict(own.get("run_options") or {})
        if device in ("local", "braket_sv", "braket_dm"):
            name = "braket_sv" if device == "local" else device
            if options.shots is None:
                return _Local(ansatz.circuit, name)
            local = _need("braket.devices", "backend braket").LocalSimulator(name)
            return _Shots(ansatz.circuit, local, name, True, run)
        if isinstance(device, str):
            device = self._managed(arn_of(device), options.device_options)
            _fits(device, ansatz.circuit.qubits)
        arn = str(getattr(device, "arn", ""))
        name = arn or str(getattr(device, "name", type(device).__name__))
        return _Shots(ansatz.circuit, device, name, arn.endswith(SIMULATORS), run)

    def _managed(self, arn: str, options: dict[str, Any]) -> Any:
        aws = _need("braket.aws", "Braket's managed devices")
        try:
            return aws.AwsDevice(arn, **options)
        except Exception as error:
            kind = type(error).__name__
            if kind in ("NoCredentialsError", "NoRegionError", "PartialCredentialsError") or (
                kind == "ProfileNotFound"
            ):
                raise CredentialsError(
                    f"backend {self.name}: AWS credentials are missing ({kind}); "
                    "run `aws configure`"
                ) from None
            raise failed(self.name, f"opening device {arn}", error) from None


class BraketVQE(_Braket):
    """VQE on Braket (backend ``braket-vqe``)."""

    algorithm = "vqe"


class BraketQAOA(_Braket):
    """QAOA on Braket (backend ``braket-qaoa``)."""

    algorithm = "qaoa"


def _need(module: str, what: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingExtraError(what, "braket") from None


def _fits(device: Any, qubits: int) -> None:
    paradigm = getattr(getattr(device, "properties", None), "paradigm", None)
    most = getattr(paradigm, "qubitCount", None)
    if most is not None and qubits > most:
        raise BackendError(
            f"the model needs {qubits} qubits and device {getattr(device, 'name', '')} has "
            f"{most}; use a smaller model or a larger device"
        )
