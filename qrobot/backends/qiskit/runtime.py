"""IBM hardware by Qiskit Runtime: transpiled circuits, what they cost, jobs that outlive us."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot._extras import load
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import Engine, JobEngine, attempt, check_size
from qrobot.backends.qiskit.jobs import TITLE, RuntimeJobs, machine
from qrobot.errors import InputError
from qrobot.jobs import Estimate, JobOptions, by_time, price
from qrobot.jobs.cost import price_source

__all__ = [
    "Measured",
    "RuntimeEngine",
    "Transpiled",
    "backend_of",
    "check_fit",
    "is_simulated",
    "open_mode",
]


OVERHEAD = 2.0
"""Seconds of QPU that are assumed for a job beside its shots: loading and calibration."""

REPETITION = 250e-6
"""Seconds between shots, where the machine does not tell its own."""

LAYER = 1e-6
"""Seconds of a layer of gates, where the machine does not tell its gates' durations."""


class Transpiled:
    """A circuit as a backend takes it; parameters are bound in the sequence of the rotations.

    Parameters
    ----------
    whole
        A Qiskit circuit with a ParameterVector, measured.
    backend
        What to transpile for, by a preset pass manager.
    level, seed
        Of the transpiler.
    """

    def __init__(self, whole: Any, backend: Any, level: int, seed: int | None) -> None:
        from qiskit.transpiler import generate_preset_pass_manager

        manager = generate_preset_pass_manager(
            optimization_level=level, backend=backend, seed_transpiler=seed
        )
        self.circuit = manager.run(whole)
        # Transpiled circuits sort their parameters in their own way.
        self._at = [parameter.index for parameter in self.circuit.parameters]
        self.facts = {"depth": self.circuit.depth(), "gates": dict(self.circuit.count_ops())}

    def pub(self, angles: Floats) -> tuple[Any, Floats]:
        """Return circuit and values as a sampler primitive takes them."""
        return self.circuit, angles[self._at]

    def seconds(self, backend: Any) -> float | None:
        """Return the length of a shot by the backend's durations, or ``None``."""
        try:
            return float(self.circuit.estimate_duration(backend.target, unit="s"))
        except Exception:  # the target knows no durations; each version has an error of its own
            return None


class Measured(Engine):
    """Shots of a sampler primitive of this machine, such as Aer's."""

    def __init__(self, circuit: Circuit, made: Transpiled, sampler: Any) -> None:
        super().__init__(circuit)
        self._made, self._sampler = made, sampler
        self.facts = dict(made.facts)

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots."""
        self.executions += 1
        del seed  # set when the primitive was made, where it takes one
        measured = attempt(
            "qiskit",
            "running the circuit",
            lambda: self._sampler.run([self._made.pub(angles)], shots=shots).result()[0].data.meas,
        )
        return np.asarray(measured.to_bool_array(order="little"), dtype=np.int8)


class RuntimeEngine(JobEngine):
    """Shots by the sampler primitive of Qiskit Runtime: each run is a job.

    Parameters
    ----------
    circuit
        What to run.
    made
        The same, transpiled.
    mode
        A backend, session or batch.
    seed
        Of a simulated backend; hardware takes none.
    """

    title = TITLE

    def __init__(self, circuit: Circuit, made: Transpiled, mode: Any, seed: int | None) -> None:
        super().__init__(circuit)
        runtime = _runtime()
        self._made, self._mode, self._target = made, mode, backend_of(mode)
        self._sampler = _sampler_class(runtime)(mode=mode)
        if seed is not None and is_simulated(self._target):
            self._sampler.options.simulator.seed_simulator = seed
        self.facts = {**made.facts, "device": name_of(self._target), "mode": type(mode).__name__}
        self._length = made.seconds(self._target)

    def jobs(self, angles: Floats, shots: int) -> RuntimeJobs:
        """Return the job of one run, not submitted yet."""

        def start(label: str) -> Any:
            self._sampler.options.environment.job_tags = [label]
            return self._sampler.run([self._made.pub(angles)], shots=shots)

        return RuntimeJobs(
            self.backend,
            start,
            device=name_of(self._target),
            cost=self.cost(shots),
            sdk=getattr(self._target, "service", None),
        )

    def run(self, angles: Floats, shots: int, job_options: JobOptions) -> Any:
        """Submit one job; a simulated one dies with this process, so it is always waited for."""
        waits = job_options.wait or is_simulated(self._target)
        return super().run(angles, shots, replace(job_options, wait=waits))

    def cost(self, shots: int, runs: int = 1) -> Estimate:
        """Return what jobs of this circuit would cost, by the seconds of the machine."""
        if is_simulated(self._target):
            return Estimate(0.0, 0.0, "local: a simulated machine, nothing is billed")
        told = getattr(self._target, "default_rep_delay", None)
        pause = REPETITION if told is None else float(told)
        length = self._length
        source = "by the machine's durations"
        if length is None:
            length = LAYER * self.facts["depth"]
            source = f"assumed, {LAYER:g} s a layer"
        note = (
            f"{runs} job(s) of {OVERHEAD:g} s (assumed) and {shots} shots of {length:.3g} s"
            f" ({source}) + {pause:.3g} s; price {price_source('ibm-second')}"
        )
        if self.facts["mode"] == "Session":
            note += "; a session bills all the time that it is open"
        seconds = runs * (OVERHEAD + shots * (length + pause))
        return by_time(seconds, price("ibm-second"), "QPU time", note)


def open_mode(device: Any, mode: Any, qubits: int, job_options: JobOptions) -> Any:
    """Return a backend, session or batch with enough qubits.

    Parameters
    ----------
    device
        ``ibm`` or ``ibm:<name>``, where there is no mode.
    mode
        A backend, session or batch.
    qubits
        That it must have.
    job_options
        Limits of the calls.

    Raises
    ------
    BackendError
        When the model does not fit, or the account has no such machine.
    CredentialsError, RemoteError
        When the service refuses, or cannot be reached.
    """
    _runtime()
    if mode is None:
        name = str(device).partition(":")[2]
        mode = machine(name, qubits, job_options)
    check_fit(mode, qubits)
    return mode


def backend_of(mode: Any) -> Any:
    """Return the backend of a mode: itself, or what a session or batch runs on.

    Raises
    ------
    InputError
        When it is something else.
    """
    backend = getattr(mode, "_backend", mode)  # sessions give only its name in public
    # Asked of the class: the attribute itself of a real machine asks the service.
    if not (hasattr(type(backend), "target") or "target" in getattr(backend, "__dict__", {})):
        raise InputError(
            f"a {type(mode).__name__} is not a backend, session or batch", field="mode"
        )
    return backend


def check_fit(mode: Any, qubits: int) -> None:
    """Refuse a model with more qubits than the backend of a mode has."""
    backend = backend_of(mode)
    check_size(qubits, getattr(backend, "num_qubits", None), name_of(backend))


def name_of(backend: Any) -> str:
    """Return a backend's name, which older ones tell when called."""
    name = getattr(backend, "name", type(backend).__name__)
    return str(name() if callable(name) else name)


def is_simulated(backend: Any) -> bool:
    """Return whether a backend is a fake one: no service runs its jobs, or bills them."""
    return getattr(backend, "service", None) is None


def _runtime() -> Any:
    return load("qiskit_ibm_runtime", "IBM hardware")


def _sampler_class(runtime: Any) -> Any:
    """Return the sampler primitive; 0.50 deprecated SamplerV2 for one on the client's side."""
    try:
        return importlib.import_module("qiskit_ibm_runtime.executor_sampler").Sampler
    except ImportError:
        return runtime.SamplerV2
