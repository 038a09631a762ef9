"""VQE and QAOA on PennyLane, by adjoint gradients on lightning.qubit or any other device.

Variable k is wire n - 1 - k: PennyLane counts its first wire as the highest bit of an index.
Plugins ask a service by themselves: there are no jobs of ours, and no price.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import dimod
import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot._extras import load, missing
from qrobot.backends.braket.devices import TITLE, arn_of, check_credentials
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import Engine, RemoteEngine, StateEngine, attempt, room
from qrobot.backends.gate.form import terms
from qrobot.backends.gate.sampler import VariationalSampler
from qrobot.backends.gate.search import Options
from qrobot.backends.sampler import Parameter, samples_of_bits
from qrobot.errors import InputError, MissingExtraError
from qrobot.jobs import Estimate, JobOptions, redact_data, with_retries

__all__ = [
    "LOCAL",
    "PennyLaneQAOA",
    "PennyLaneVQE",
    "PluginEngine",
    "admitted",
    "hamiltonian",
    "is_local",
    "limited",
]


LOCAL = (
    "lightning.", "default.", "null.", "reference.", "braket.local.", "qiskit.aer",
)  # fmt: skip
"""How devices begin that are known to be simulated here. Every other one may be a machine that
bills: it is treated as remote, at a cost that nobody knows."""


def is_local(device: Any) -> bool:
    """Return whether a device is known to be simulated on this machine."""
    return isinstance(device, str) and device.startswith(LOCAL)


class PluginEngine(RemoteEngine):
    """A circuit on a remote device of a plugin, which waits for its answers.

    Parameters
    ----------
    circuit
        What to run.
    name
        Of the device.
    make
        Returns the device within limits; called for the first run, when the cost is settled.
    """

    title = "PennyLane's device"

    def __init__(self, circuit: Circuit, name: str, make: Callable[[JobOptions], Engine]) -> None:
        super().__init__(circuit)
        self._make = make
        self._device: Engine | None = None
        self.facts = {"device": name}

    def cost(self, shots: int, runs: int = 1) -> Estimate:
        """Return that nobody knows."""
        del shots, runs
        return Estimate(
            None, None, "PennyLane's plugins tell no price; the backends braket-* and qiskit-* do"
        )

    def run(self, angles: Floats, shots: int, job_options: JobOptions) -> dimod.SampleSet:
        """Run the circuit and wait for it."""
        self.executions += 1
        if self._device is None:
            self._device = self._make(job_options)
        bits = self._device.samples(angles, shots, 0)
        info = redact_data((job_options.context or {}).get("info", {}))
        return samples_of_bits(self.bqm, bits, info)


def admitted(device: Any, options: Mapping[str, Any], job_options: JobOptions) -> Any:
    """Return a remote device that may be asked; nothing is asked yet.

    Raises
    ------
    InputError
        When the answer shall not be waited for, or the ARN is none.
    BackendError
        When the ARN is of a retired device.
    CredentialsError
        When there are no credentials.
    """
    if not job_options.wait:
        raise InputError(
            "PennyLane waits for its devices", field="wait", advice="use a backend braket-*"
        )
    if device == "braket.aws.qubit":
        arn_of(str(options.get("device_arn", "")))
        if options.get("aws_session") is None:
            with_retries(check_credentials, what=TITLE, backoff=job_options.backoff)
    return device


def limited(name: str, options: Options, job_options: JobOptions) -> dict[str, Any]:
    """Return the options of a device, with the timeout where it takes one."""
    given = dict(options.device_options)
    if name == "braket.aws.qubit" and job_options.timeout is not None:
        given.setdefault("poll_timeout_seconds", job_options.timeout)
    return given


DEFAULT = "lightning.qubit"
ADJOINT = ("lightning.qubit", "lightning.kokkos", "lightning.gpu")
"""Devices that derive a diagonal observable of any kind by one run forward and one back."""

EXACT = (*ADJOINT, "default.qubit", "braket.local.qubit")
"""Local devices with exact probabilities."""

PLUGINS = {
    "braket": "amazon_braket_pennylane_plugin",
    "lightning": "pennylane_lightning",
    "qiskit": "pennylane_qiskit",
}
"""What brings devices whose names begin so."""

GATES = {"h": "Hadamard", "rx": "RX", "ry": "RY", "rz": "RZ", "rzz": "IsingZZ", "cz": "CZ"}


def hamiltonian(bqm: Any) -> Any:
    """Return a model's Ising form as a PennyLane Hamiltonian.

    Parameters
    ----------
    bqm
        A dimod model; wire k is the k-th variable, state 1 is x = 1 (dimod: s = +1).
    """
    qml = load("pennylane", "PennyLane Hamiltonians")
    words = terms(bqm)
    made = [
        qml.prod(*(qml.Z(q) for q in qubits))
        if len(qubits) > 1
        else qml.Z(qubits[0])
        if qubits
        else qml.Identity(0)
        for _, qubits in words
    ]
    return qml.Hamiltonian([value for value, _ in words], made)


class _Shots(Engine):
    """Measured shots of any device."""

    def __init__(self, circuit: Circuit, name: str, device: Any) -> None:
        super().__init__(circuit)
        self._qml = load("pennylane", "backend pennylane")
        self._device = device
        # Braket's plugin reads observables alone: Z of each wire for the wires together.
        self._by_wire = "braket" in name.lower()
        self.facts = {"device": name}

    def _apply(self, angles: Any) -> None:
        last = self.circuit.qubits - 1
        for gate, angle in self.circuit.turned(angles):
            turn = getattr(self._qml, GATES[gate.name])
            turn(*([angle] if gate.slot >= 0 else []), wires=[last - q for q in gate.qubits])

    def _node(self, measure: Callable[[], Any], method: str | None = None) -> Any:
        """Return a measurement as a function of the angles, derived by a method."""

        def circuit(angles: Any) -> Any:
            self._apply(angles)
            return measure()

        return self._qml.QNode(circuit, self._device, diff_method=method)

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots; a remote device cannot be seeded."""
        self.executions += 1
        del seed
        qml = self._qml

        def measure() -> Any:
            if self._by_wire:
                return [qml.sample(qml.Z(wire)) for wire in range(self.circuit.qubits)]
            return qml.sample(wires=range(self.circuit.qubits))

        def run() -> Any:
            return np.asarray(qml.set_shots(self._node(measure), shots)(angles))

        measured = attempt("pennylane", "running the circuit", run)
        if self._by_wire:
            measured = (1 - measured.reshape(-1, shots).T) / 2
        found: Bits = measured.reshape(shots, -1)[:, ::-1].astype(np.int8)
        return found


class _Exact(_Shots, StateEngine):
    """Exact probabilities, and derivatives by the device where it has them."""

    def __init__(self, circuit: Circuit, name: str, device: Any, method: str | None) -> None:
        super().__init__(circuit, name, device)
        adjoint = "adjoint" if name in ADJOINT else "parameter-shift"
        self._native = name in (*ADJOINT, "default.qubit")
        self._method = method or adjoint
        self.gradients = self._native and self._method in ("adjoint", "backprop")
        self.facts["diff_method"] = self._method

    def probabilities(self, angles: Floats) -> Floats:
        self.executions += 1
        return np.asarray(self._node(self._probs)(angles), dtype=np.float64)

    def _probs(self) -> Any:
        return self._qml.probs(wires=range(self.circuit.qubits))

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        return StateEngine.samples(self, angles, shots, seed)

    def slope(self, angles: Floats, weights: Floats) -> tuple[float, Floats]:
        if not self._native:
            return StateEngine.slope(self, angles, weights)
        self.executions += 2 * angles.size + 1 if self._method == "parameter-shift" else 1
        qml = self._qml
        point = qml.numpy.array(angles, requires_grad=True)
        if self._method == "backprop":  # knows no sparse observables, but derives probabilities
            node = self._node(self._probs, "backprop")
            slope = qml.grad(lambda turns: qml.math.dot(node(turns), weights))
            found = np.asarray(slope(point), dtype=np.float64)
            return float(slope.forward), found
        # A tail is constant above its end: less that, few entries are left.
        level = float(weights.max())
        kept = np.flatnonzero(weights < level)
        kept = kept if kept.size else np.zeros(1, dtype=np.int64)
        rows = np.searchsorted(kept, np.arange(weights.size + 1))
        matrix = importlib.import_module("scipy.sparse").csr_matrix(
            (weights[kept] - level, kept, rows), shape=(weights.size, weights.size)
        )
        observable = qml.SparseHamiltonian(matrix, wires=range(self.circuit.qubits))
        slope = qml.grad(self._node(lambda: qml.expval(observable), self._method))
        found = np.asarray(slope(point), dtype=np.float64)
        return float(slope.forward) + level, found


class _PennyLane(VariationalSampler):
    """Both algorithms on PennyLane.

    ``device``: any device name (``lightning.qubit`` is the default; ``default.qubit``,
    ``braket.local.qubit``, ``braket.aws.qubit`` ...), made with ``device_options``.
    ``diff_method``: ``adjoint`` (default where the device has it), ``parameter-shift``, or
    ``backprop`` on ``default.qubit``.
    """

    sdk = "pennylane"
    own: ClassVar[dict[str, Parameter]] = {
        "diff_method": Parameter("choice", choices=("adjoint", "parameter-shift", "backprop"))
    }

    def check(self, qubits: int, options: Options) -> bool:
        load("pennylane", f"backend {self.name}")
        method = options.own.get("diff_method")
        device = options.device or DEFAULT
        exact = options.shots is None and not options.device_options.get("shots")
        allowed = _methods(device if exact else None)
        if method is not None and method not in allowed:
            where = f"device {device}" + ("" if exact else " with shots")
            raise InputError(
                f"{method!r} is not a way to derive on {where}",
                field="diff_method",
                advice=f"use {' or '.join(allowed)}",
            )
        if isinstance(device, str):
            _installed(device)
        elif not hasattr(device, "execute") and not hasattr(device, "apply"):
            raise InputError(
                f"{device!r} is not a PennyLane device", field="device", advice="give its name"
            )
        else:
            options.refuse_device_options("a device object")
        if not is_local(device):  # it has limits of its own
            return False
        room(qubits, f"device {device}")
        return True

    def engine(self, circuit: Circuit, options: Options) -> Engine:
        name = str(options.device or DEFAULT)
        given = dict(options.device_options)
        exact = name in EXACT and options.shots is None and not given.get("shots")
        if options.seed is not None and name in (*ADJOINT, "default.qubit"):
            given.setdefault("seed", options.seed)
        device = _made(name, circuit.qubits, given)
        if exact:
            return _Exact(circuit, name, device, options.own.get("diff_method"))
        return _Shots(circuit, name, device)

    def connect(self, qubits: int, options: Options, job_options: JobOptions) -> Any:
        """Return a remote device's name, or the object that it is."""
        del qubits  # the device's own limits are told by the device
        if isinstance(options.device, str):
            _installed(options.device)
        return admitted(options.device, options.device_options, job_options)

    def remote_engine(self, machine: Any, circuit: Circuit, options: Options) -> PluginEngine:
        """Return the device, ready to run a circuit; it is made for the first run."""
        name = machine if isinstance(machine, str) else type(machine).__name__

        def make(job_options: JobOptions) -> Engine:
            device = machine
            if isinstance(machine, str):
                device = _made(machine, circuit.qubits, limited(machine, options, job_options))
            return _Shots(circuit, name, device)

        return PluginEngine(circuit, name, make)


class PennyLaneVQE(_PennyLane):
    """VQE on PennyLane (backend ``pennylane-vqe``)."""

    algorithm = "vqe"


class PennyLaneQAOA(_PennyLane):
    """QAOA on PennyLane (backend ``pennylane-qaoa``)."""

    algorithm = "qaoa"


def _methods(device: Any) -> tuple[str, ...]:
    """Return how derivatives can be had on a device; ``None``: of measured shots."""
    if device == "default.qubit":
        return ("adjoint", "backprop", "parameter-shift")
    return ("adjoint", "parameter-shift") if device in ADJOINT else ("parameter-shift",)


def _installed(name: str) -> None:
    """Refuse a device whose plugin is absent; the device itself is not made."""
    if name not in load("pennylane", "backend pennylane").plugin_devices:
        raise _absent(name)


def _made(name: str, qubits: int, options: dict[str, Any]) -> Any:
    qml = load("pennylane", "backend pennylane")
    refused = False

    def make() -> Any:
        nonlocal refused
        try:
            return qml.device(name, wires=qubits, **options)
        except Exception as error:
            if type(error).__name__ != "DeviceError":
                raise
            refused = True
            return None

    device = attempt("pennylane", f"making device {name}", make)
    if refused:
        raise _absent(name)
    return device


def _absent(name: str) -> InputError | MissingExtraError:
    plugin = next((module for start, module in PLUGINS.items() if name.startswith(start)), None)
    if plugin:
        return missing(f"device {name}", plugin)
    return InputError(f"{name!r} is not a PennyLane device that is installed", field="device")
