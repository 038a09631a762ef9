"""Amazon Braket's managed devices: what fits, what it costs, and tasks that outlive us."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qrobot._arrays import Floats
from qrobot.backends.braket.devices import TITLE, properties_of
from qrobot.backends.braket.jobs import BraketTasks
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import JobEngine, check_size
from qrobot.errors import InputError
from qrobot.jobs import Estimate, by_shots, by_time, device_price, price
from qrobot.jobs.cost import price_source

__all__ = ["TaskEngine", "check_fit"]


MINIMUM = 3.0
"""Seconds that a managed simulator bills at least for a task."""

AMPLITUDES = 1e8
"""Amplitudes that a managed simulator is assumed to change in a second: on the slow side."""


class TaskEngine(JobEngine):
    """A circuit on a managed device: each run is a quantum task.

    Parameters
    ----------
    circuit
        What to run.
    device
        An ``AwsDevice``.
    build
        Returns the SDK's circuit of angles, with ZZ rotations as one gate or not.
    run_options
        For the device's ``run``.
    """

    title = TITLE

    def __init__(
        self,
        circuit: Circuit,
        device: Any,
        build: Callable[[Floats, bool], Any],
        run_options: dict[str, Any],
    ) -> None:
        super().__init__(circuit)
        self._device, self._build, self._options = device, build, run_options
        self._native = _has_zz(device)
        self.facts = {"device": device.arn}

    def jobs(self, angles: Floats, shots: int) -> BraketTasks:
        """Return the task of one run, not created yet."""
        session = getattr(self._device, "aws_session", None)
        made = self._build(angles, self._native)

        def start(label: str) -> Any:
            tags = {**self._options.get("tags", {}), "qrobot": label}
            return self._device.run(made, shots=shots, **{**self._options, "tags": tags})

        return BraketTasks(
            self.backend,
            start,
            device=self._device.arn,
            cost=self.cost(shots),
            sdk=session,
            kept={"device": self._device.arn, "region": getattr(session, "region", None)},
        )

    def cost(self, shots: int, runs: int = 1) -> Estimate:
        """Return what tasks of this circuit would cost, by the device's own price if it tells."""
        told = device_price(properties_of(self._device))
        simulator = "/quantum-simulator/" in self._device.arn
        if told is None:
            name = "braket-minute" if simulator else "braket-shot"
            told = (price(name), "minute" if simulator else "shot")
            source = f"price of a {told[1]} {price_source(name)}"
        else:
            source = f"price of a {told[1]} told by the device"
        usd, unit = told
        if unit == "shot":
            note = f"{source}, of a task {price_source('braket-task')}"
            return by_shots(runs * shots, usd, price("braket-task"), runs, note)
        if unit == "minute":
            seconds = self._seconds()
            note = (
                f"{source}; {seconds:.3g} s a task are an assumption "
                f"({AMPLITUDES:.0e} amplitudes a second, {MINIMUM:g} s at least)"
            )
            return by_time(runs * seconds, usd / 60, f"simulator ({runs} task(s))", note)
        return Estimate(None, None, f"the device bills by the {unit}, which is not known here")

    def _seconds(self) -> float:
        """Return the seconds that a managed simulator is assumed to bill for a task."""
        qubits = self.circuit.qubits
        if self._device.arn.lower().endswith("dm1"):  # a matrix, not a vector
            qubits *= 2
        return max(MINIMUM, len(self.circuit.gates) * 2.0 ** min(qubits, 80) / AMPLITUDES)


def check_fit(device: Any, qubits: int, shots: int) -> None:
    """Refuse a model or a number of shots that a device does not take.

    Raises
    ------
    BackendError
        When the device has too few qubits.
    InputError
        When it takes fewer shots a task.
    """
    known = properties_of(device)
    most = getattr(getattr(known, "paradigm", None), "qubitCount", None)
    name = getattr(device, "name", "") or device.arn
    check_size(qubits, most, name)
    allowed = getattr(getattr(known, "service", None), "shotsRange", None)
    if allowed is not None and shots > allowed[1]:
        raise InputError(
            f"device {name} takes at most {allowed[1]} shots a task, not {shots}",
            field="num_reads",
            advice="ask for fewer",
        )


def _has_zz(device: Any) -> bool:
    """Return whether ZZ rotations may stay one gate: simulators and trapped ions have it."""
    action = getattr(properties_of(device), "action", None) or {}
    for kind, about in action.items():
        if str(getattr(kind, "value", kind)) == "braket.ir.openqasm.program":
            return "zz" in {str(one).lower() for one in about.supportedOperations or ()}
    return bool(device.arn.lower().endswith(("/sv1", "/dm1")))
