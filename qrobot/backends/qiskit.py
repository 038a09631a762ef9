"""VQE and QAOA on Qiskit: statevector, Aer, and IBM hardware by Qiskit Runtime.

Qubit k is variable k. Qiskit's indices count qubit 0 as the lowest bit, as ours do.
"""

from __future__ import annotations

import importlib
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from qrobot.backends.variational.ansatz import Ansatz
from qrobot.backends.variational.circuit import Circuit
from qrobot.backends.variational.engine import Engine, StateEngine, room
from qrobot.backends.variational.ising import terms
from qrobot.backends.variational.options import Options
from qrobot.backends.variational.sampler import VariationalSampler, failed
from qrobot.errors import BackendError, CredentialsError, InputError, MissingExtraError

__all__ = ["QiskitQAOA", "QiskitVQE", "circuit_of", "sparse_pauli_op"]

Floats = npt.NDArray[np.float64]
Bits = npt.NDArray[np.int8]

LOCAL = ("statevector", "aer")


def sparse_pauli_op(bqm: Any) -> Any:
    """Return a model's Ising form as a `qiskit.quantum_info.SparsePauliOp`.

    Parameters
    ----------
    bqm
        A dimod model; qubit k is the k-th variable, state 1 is x = 1 (dimod: s = +1).
    """
    info = _need("qiskit.quantum_info", "qiskit operators", "qiskit")
    listed = [("Z" * len(qubits), list(qubits), value) for value, qubits in terms(bqm)]
    return info.SparsePauliOp.from_sparse_list(listed, num_qubits=bqm.num_variables)


def circuit_of(circuit: Circuit, angles: Any) -> Any:
    """Return a Qiskit circuit.

    Parameters
    ----------
    circuit
        What to translate.
    angles
        One a rotation: numbers, or a ParameterVector.
    """
    qiskit = _need("qiskit", "qiskit circuits", "qiskit")
    made = qiskit.QuantumCircuit(circuit.qubits)
    left = iter(angles)
    for gate in circuit.gates:
        given = (next(left),) if gate.slot >= 0 else ()
        getattr(made, gate.name)(*given, *gate.qubits)
    return made


class _Statevector(StateEngine):
    """Exact probabilities by `qiskit.quantum_info.Statevector`."""

    def probabilities(self, angles: Floats) -> Floats:
        from qiskit.quantum_info import Statevector

        self.executions += 1
        state = Statevector(circuit_of(self.circuit, angles))
        return np.asarray(state.probabilities(), dtype=np.float64)


class _Aer(StateEngine):
    """Exact probabilities by Aer's state: all qubits are saved, so none can be cut off.

    Expectations of Aer on part of the qubits can be silently wrong (qiskit-aer#2442): energies
    are taken from the whole state, and truncation is off.
    """

    def __init__(self, circuit: Circuit, options: dict[str, Any]) -> None:
        super().__init__(circuit)
        aer = _need("qiskit_aer", "device aer", "qiskit")
        self._simulator = aer.AerSimulator(
            **({"method": "statevector", "enable_truncation": False} | options)
        )

    def probabilities(self, angles: Floats) -> Floats:
        self.executions += 1
        circuit = circuit_of(self.circuit, angles)
        circuit.save_statevector()
        result = self._simulator.run(circuit).result()
        if not result.success:
            raise BackendError("device aer: the simulation failed")
        found: Floats = np.abs(np.asarray(result.get_statevector(circuit))) ** 2
        return found


class _Runtime(Engine):
    """Shots by the sampler primitive of Qiskit Runtime (or Aer's), on a transpiled circuit."""

    def __init__(
        self, circuit: Circuit, backend: Any, sampler: Any, level: int, seed: int | None
    ) -> None:
        super().__init__(circuit)
        from qiskit.circuit import ParameterVector
        from qiskit.transpiler import generate_preset_pass_manager

        self._sampler = sampler
        whole = circuit_of(circuit, ParameterVector("angle", len(circuit.rotations)))
        whole.measure_all()
        manager = generate_preset_pass_manager(
            optimization_level=level, backend=backend, seed_transpiler=seed
        )
        self._circuit = manager.run(whole)
        # Rotations by fixed names: transpiled circuits sort their parameters by name.
        self._at = [parameter.index for parameter in self._circuit.parameters]
        self.facts = {"depth": self._circuit.depth(), "gates": dict(self._circuit.count_ops())}

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        self.executions += 1
        del seed  # set when the primitive was made, where it takes one
        try:
            job = self._sampler.run([(self._circuit, angles[self._at])], shots=shots)
            if callable(getattr(job, "job_id", None)):
                self.facts.setdefault("jobs", []).append(str(job.job_id()))
            measured = job.result()[0].data.meas
        except Exception as error:
            raise failed("qiskit", "running the circuit", error) from None
        return np.asarray(measured.to_bool_array(order="little"), dtype=np.int8)


class _Qiskit(VariationalSampler):
    """Both algorithms on Qiskit.

    ``device``: ``statevector`` (default), ``aer``, or ``ibm`` / ``ibm:<name>`` (credentials
    saved by `QiskitRuntimeService.save_account`). ``mode``: a backend, session or batch of
    Qiskit Runtime to use instead, fake ones too. ``optimization_level``: of the transpiler.
    """

    sdk = "qiskit"
    extra = "qiskit"
    own: ClassVar[tuple[str, ...]] = ("mode", "optimization_level")

    def check(self, qubits: int, options: Options, own: dict[str, Any]) -> bool:
        """Refuse what does not fit; True for devices of this machine."""
        _need("qiskit", f"backend {self.name}", self.extra)
        level = own.get("optimization_level", 3)
        if isinstance(level, bool) or level not in range(4):
            raise InputError(f"{level!r} is no level", field="optimization_level", mend="use 0..3")
        mode = own.get("mode")
        if mode is not None:
            _fits(_backend_of(mode), qubits)
            return False
        device = options.device or "statevector"
        if device in LOCAL:
            if device == "aer":
                _need("qiskit_aer", "device aer", "qiskit")
            room(qubits, f"device {device}")
            return True
        if isinstance(device, str) and device.partition(":")[0] == "ibm":
            _need("qiskit_ibm_runtime", f"device {device}", "ibm")
            return False
        raise InputError(
            f"{device!r} is no device",
            field="device",
            mend=f"use one of {', '.join(LOCAL)}, ibm, ibm:<name>, or mode=",
        )

    def engine(self, ansatz: Ansatz, options: Options, own: dict[str, Any]) -> Engine:
        """Return the device, ready to run the ansatz."""
        device, mode = options.device or "statevector", own.get("mode")
        made: Engine
        if mode is None and device == "statevector":
            made = _Statevector(ansatz.circuit)
        elif mode is None and device == "aer" and options.shots is None:
            made = _Aer(ansatz.circuit, options.device_options)
        else:
            made = self._runtime(ansatz, options, own)
        made.facts.setdefault("device", str(device))
        return made

    def _runtime(self, ansatz: Ansatz, options: Options, own: dict[str, Any]) -> Engine:
        level, seed, mode = own.get("optimization_level", 3), options.seed, own.get("mode")
        if mode is None and options.device == "aer":
            aer = _need("qiskit_aer", "device aer", "qiskit")
            primitives = _need("qiskit_aer.primitives", "device aer", "qiskit")
            simulator = aer.AerSimulator(**options.device_options)
            sampler = primitives.SamplerV2(
                seed=seed, options={"backend_options": options.device_options}
            )
            return _Runtime(ansatz.circuit, simulator, sampler, level, seed)
        runtime = _need("qiskit_ibm_runtime", "IBM hardware", "ibm")
        if mode is None:
            mode = _hardware(runtime, str(options.device), ansatz.circuit.qubits)
        backend = _backend_of(mode)
        _fits(backend, ansatz.circuit.qubits)
        sampler = _sampler_class(runtime)(mode=mode)
        if seed is not None and getattr(backend, "service", None) is None:
            sampler.options.simulator.seed_simulator = seed  # a fake backend: it is simulated
        made = _Runtime(ansatz.circuit, backend, sampler, level, seed)
        made.facts["device"] = _name_of(backend)
        return made


class QiskitVQE(_Qiskit):
    """VQE on Qiskit (backend ``qiskit-vqe``)."""

    algorithm = "vqe"


class QiskitQAOA(_Qiskit):
    """QAOA on Qiskit (backend ``qiskit-qaoa``)."""

    algorithm = "qaoa"


def _need(module: str, what: str, extra: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingExtraError(what, extra) from None


def _sampler_class(runtime: Any) -> Any:
    """Return the sampler primitive; 0.50 deprecated SamplerV2 for one on the client's side."""
    try:
        return importlib.import_module("qiskit_ibm_runtime.executor_sampler").Sampler
    except ImportError:
        return runtime.SamplerV2


def _hardware(runtime: Any, device: str, qubits: int) -> Any:
    """Return a backend of the user's account."""
    name = device.partition(":")[2]
    try:
        service = runtime.QiskitRuntimeService()
    except Exception as error:  # a bogus instance raises a bare AttributeError
        raise CredentialsError(
            f"IBM Quantum did not accept the saved account ({type(error).__name__}); save one "
            'with QiskitRuntimeService.save_account(channel="ibm_quantum_platform", ...)'
        ) from None
    try:
        if name:
            return service.backend(name)
        return service.least_busy(min_num_qubits=qubits, operational=True, simulator=False)
    except Exception as error:
        raise failed("qiskit", f"finding device {device}", error) from None


def _backend_of(mode: Any) -> Any:
    """Return the backend of a mode: itself, or what a session or batch runs on."""
    backend = getattr(mode, "_backend", mode)  # sessions give only its name in public
    if not hasattr(backend, "target"):
        raise InputError(f"a {type(mode).__name__} is no backend, session or batch", field="mode")
    return backend


def _name_of(backend: Any) -> str:
    name = getattr(backend, "name", type(backend).__name__)
    return str(name() if callable(name) else name)


def _fits(backend: Any, qubits: int) -> None:
    most = getattr(backend, "num_qubits", None)
    if most is not None and qubits > most:
        raise BackendError(
            f"the model needs {qubits} qubits and device {_name_of(backend)} has {most}; "
            "use a smaller model or a larger device"
        )
