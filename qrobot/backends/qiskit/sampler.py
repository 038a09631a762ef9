"""VQE and QAOA on Qiskit: statevector, Aer, and IBM hardware by Qiskit Runtime.

Qubit k is variable k. Qiskit's indices count qubit 0 as the lowest bit, as ours do.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from qrobot._arrays import Floats
from qrobot._extras import is_installed, load
from qrobot.backends.gate import resources
from qrobot.backends.gate.circuit import TURNING, Circuit
from qrobot.backends.gate.engine import Engine, StateEngine, room
from qrobot.backends.gate.form import terms
from qrobot.backends.gate.resources import PARALLEL
from qrobot.backends.gate.sampler import VariationalSampler
from qrobot.backends.gate.search import Options
from qrobot.backends.qiskit.runtime import (
    Measured,
    RuntimeEngine,
    Transpiled,
    backend_of,
    check_fit,
    is_simulated,
    open_mode,
)
from qrobot.backends.sampler import Parameter
from qrobot.errors import BackendError, InputError
from qrobot.jobs import JobOptions

__all__ = ["QiskitQAOA", "QiskitVQE", "circuit_of", "sparse_pauli_op"]


LOCAL = ("statevector", "aer")

EXACT = ("automatic", "statevector", "density_matrix", "matrix_product_state")
"""Methods of Aer that can tell the probabilities of any circuit of ours."""

CLASSES = {
    "cz": "CZGate", "h": "HGate", "phase": "PhaseGate", "rx": "RXGate", "ry": "RYGate",
    "rz": "RZGate", "rzz": "RZZGate", "swap": "SwapGate", "x": "XGate",
}  # fmt: skip


def sparse_pauli_op(bqm: Any) -> Any:
    """Return a model's Ising form as a `qiskit.quantum_info.SparsePauliOp`.

    Parameters
    ----------
    bqm
        A dimod model; qubit k is the k-th variable, state 1 is x = 1 (dimod: s = +1).
    """
    info = load("qiskit.quantum_info", "qiskit operators")
    listed = [("Z" * len(qubits), list(qubits), value) for value, qubits in terms(bqm)]
    return info.SparsePauliOp.from_sparse_list(listed, num_qubits=bqm.num_variables)


def circuit_of(circuit: Circuit, angles: Any = ()) -> Any:
    """Return a Qiskit circuit.

    Parameters
    ----------
    circuit
        What to translate.
    angles
        One a searched rotation: numbers, or a ParameterVector.
    """
    qiskit = load("qiskit", "qiskit circuits")
    library = load("qiskit.circuit.library", "qiskit circuits")
    made = qiskit.QuantumCircuit(circuit.qubits)
    for gate, angle in circuit.turned(angles):
        turn = getattr(library, CLASSES[gate.name])(*([angle] if gate.name in TURNING else []))
        if gate.controls:
            # Qiskit reads the control state with the first control as its lowest bit.
            held = sum(value << k for k, value in enumerate(gate.control_values))
            turn = turn.control(len(gate.controls), ctrl_state=held, annotated=False)
        made.append(turn, [*gate.controls, *gate.qubits])
    return made


class _Statevector(StateEngine):
    """Exact probabilities by `qiskit.quantum_info.Statevector`."""

    def probabilities(self, angles: Floats) -> Floats:
        from qiskit.quantum_info import Statevector

        self.executions += 1
        state = Statevector(circuit_of(self.circuit, angles))
        return np.asarray(state.probabilities(), dtype=np.float64)


def _run(simulator: Any, circuit: Any) -> Any:
    result = simulator.run(circuit).result()
    if not result.success:
        raise BackendError("device aer: the simulation failed")
    return result


class _Aer(StateEngine):
    """Exact probabilities by Aer's state: all qubits are saved, so none can be cut off.

    Expectations of Aer on part of the qubits can be silently wrong (qiskit-aer#2442): energies
    are taken from the whole state, and truncation is off.
    """

    def __init__(self, circuit: Circuit, options: dict[str, Any]) -> None:
        super().__init__(circuit)
        options = _threaded(options, circuit.qubits)
        aer = load("qiskit_aer", "device aer")
        self._simulator = aer.AerSimulator(
            **({"method": "statevector", "enable_truncation": False} | options)
        )

    def probabilities(self, angles: Floats) -> Floats:
        self.executions += 1
        circuit = circuit_of(self.circuit, angles)
        circuit.save_statevector()
        result = _run(self._simulator, circuit)
        found: Floats = np.abs(np.asarray(result.get_statevector(circuit))) ** 2
        return found


class _MixedAer(StateEngine):
    """Exact probabilities, under a noise model too, by Aer's density matrix.

    A state vector under noise is one random trajectory of many: only the density matrix, of
    4**n numbers, has them all.
    """

    def __init__(self, circuit: Circuit, options: Options) -> None:
        super().__init__(circuit)
        aer = load("qiskit_aer", "device aer")
        self._simulator = aer.AerSimulator(
            **_threaded(options.device_options, 2 * circuit.qubits)
            | {"method": "density_matrix", "enable_truncation": False}
        )
        made = _transpiled(circuit, self._simulator, options, measure=False)
        self._made, self.facts = made, dict(made.facts)
        layout = made.circuit.layout
        order = range(circuit.qubits) if layout is None else layout.final_index_layout()
        self._made.circuit.save_probabilities(list(order))

    def probabilities(self, angles: Floats) -> Floats:
        self.executions += 1
        circuit, values = self._made.pub(angles)
        result = _run(self._simulator, circuit.assign_parameters(values))
        return np.asarray(result.data()["probabilities"], dtype=np.float64)


def _noise_of(options: Options) -> Any:
    """Return the noise model that Aer is given, or None when it does nothing."""
    model = options.device_options.get("noise_model")
    if model is None:
        return None
    noise = load("qiskit_aer.noise", "device aer").NoiseModel
    if not isinstance(model, noise):
        raise InputError(
            f"{model!r} is not a noise model of Aer",
            field="device_options.noise_model",
            advice="give a qiskit_aer.noise.NoiseModel, from Python",
        )
    return None if model.is_ideal() else model


def _is_mixed(options: Options) -> bool:
    """Return whether exact probabilities of Aer need its density matrix."""
    method = options.device_options.get("method")
    return method == "density_matrix" or _noise_of(options) is not None


def _check_exact(qubits: int, options: Options) -> None:
    """Refuse what Aer's exact probabilities cannot be had of.

    That is a density matrix beyond memory, a method that knows no state of these circuits, and
    measurements that err too: a density matrix knows the state, not what is read.
    """
    method = options.device_options.get("method", EXACT[0])
    if method not in EXACT:
        raise InputError(
            f"{method!r} gives no exact probabilities of these circuits",
            field="device_options.method",
            advice=f"use one of {', '.join(EXACT)}, or give shots, such as shots=1000",
        )
    if not _is_mixed(options):
        return
    model = _noise_of(options)
    what = f"the density matrix of {qubits} qubits{' under noise' if model else ''} on device aer"
    resources.require(3 * 16 << 2 * qubits, what, "give shots, which take one trajectory each")
    if model is not None and any(
        error.get("type") == "roerror" for error in model.to_dict()["errors"]
    ):
        raise InputError(
            "the noise model has readout errors, which exact probabilities leave out",
            field="shots",
            advice="give shots, such as shots=1000",
        )


class _Qiskit(VariationalSampler):
    """Both algorithms on Qiskit.

    ``device``: ``aer`` (default where it is installed), ``statevector``, or ``ibm`` /
    ``ibm:<name>`` (credentials saved by `QiskitRuntimeService.save_account`). ``mode``: a
    backend, session or batch of Qiskit Runtime to use instead, fake ones too.
    ``optimization_level``: of the transpiler.
    """

    sdk = "qiskit"
    own: ClassVar[dict[str, Parameter]] = {
        "mode": Parameter("any"),
        "optimization_level": Parameter("whole", 0, 3, optional=False),
    }

    def check(self, qubits: int, options: Options) -> bool:
        """Refuse what does not fit; True for devices of this machine."""
        load("qiskit", f"backend {self.name}")
        mode = options.own.get("mode")
        if mode is not None or _device(options) == "statevector":
            options.refuse_device_options("a mode" if mode is not None else "device statevector")
        if mode is not None:
            check_fit(mode, qubits)
            return False
        device = _device(options)
        if device in LOCAL:
            if device == "aer":
                load("qiskit_aer", "device aer")
            room(qubits, f"device {device}")
            if device == "aer":
                _noise_of(options)
                if options.shots is None:
                    _check_exact(qubits, options)
            return True
        if isinstance(device, str) and device.partition(":")[0] == "ibm":
            load("qiskit_ibm_runtime", f"device {device}")
            return False
        raise InputError(
            f"{device!r} is not a device",
            field="device",
            advice=f"use one of {', '.join(LOCAL)}, ibm, ibm:<name>, or mode=",
        )

    def runs_remotely(self, **parameters: Any) -> bool:
        """Return whether `sample` with these parameters asks another machine."""
        mode = parameters.get("mode")
        if hasattr(getattr(mode, "_backend", mode), "target") and is_simulated(backend_of(mode)):
            return False
        return super().runs_remotely(**parameters)

    def engine(self, circuit: Circuit, options: Options) -> Engine:
        made: Engine
        if _device(options) == "statevector":
            made = _Statevector(circuit)
        elif options.shots is None and _is_mixed(options):
            made = _MixedAer(circuit, options)
        elif options.shots is None:
            made = _Aer(circuit, options.device_options)
        else:
            aer = load("qiskit_aer", "device aer")
            primitives = load("qiskit_aer.primitives", "device aer")
            given = _threaded(options.device_options, circuit.qubits)
            simulator = aer.AerSimulator(**given)
            sampler = primitives.SamplerV2(seed=options.seed, options={"backend_options": given})
            made = Measured(circuit, _transpiled(circuit, simulator, options), sampler)
        made.facts.setdefault("device", str(_device(options)))
        return made

    def connect(self, qubits: int, options: Options, job_options: JobOptions) -> Any:
        """Return the mode that jobs run in; its backend holds the model."""
        return open_mode(options.device, options.own.get("mode"), qubits, job_options)

    def remote_engine(self, machine: Any, circuit: Circuit, options: Options) -> RuntimeEngine:
        made = _transpiled(circuit, backend_of(machine), options)
        return RuntimeEngine(circuit, made, machine, options.seed)


class QiskitVQE(_Qiskit):
    """VQE on Qiskit (backend ``qiskit-vqe``)."""

    algorithm = "vqe"


class QiskitQAOA(_Qiskit):
    """QAOA on Qiskit (backend ``qiskit-qaoa``)."""

    algorithm = "qaoa"


def _device(options: Options) -> Any:
    """Return the device: many times faster than Qiskit's own state from 14 qubits on, so Aer."""
    if options.device is not None:
        return options.device
    return "aer" if is_installed("qiskit_aer") else "statevector"


def _threaded(options: dict[str, Any], qubits: int) -> dict[str, Any]:
    """Return Aer's options with one thread for a small state, unless the caller chose."""
    return ({"max_parallel_threads": 1} if qubits < PARALLEL else {}) | dict(options)


def _transpiled(
    circuit: Circuit, backend: Any, options: Options, *, measure: bool = True
) -> Transpiled:
    from qiskit.circuit import ParameterVector

    whole = circuit_of(circuit, ParameterVector("angle", len(circuit.rotations)))
    if measure:
        whole.measure_all()
    return Transpiled(whole, backend, options.own.get("optimization_level", 3), options.seed)
