"""PennyLane's plugins that ask a service by themselves: no jobs of ours, and no price."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import dimod

from qrobot._arrays import Floats
from qrobot.backends.braket.devices import TITLE, arn_of, check_credentials
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import Engine, RemoteEngine
from qrobot.backends.gate.search import Options
from qrobot.errors import InputError
from qrobot.jobs import Estimate, JobOptions, redact_data, with_retries

__all__ = ["LOCAL", "PluginEngine", "admitted", "is_local", "limited"]


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
        values = bits if self.bqm.vartype is dimod.BINARY else 2 * bits - 1
        info = redact_data((job_options.context or {}).get("info", {}))
        return dimod.SampleSet.from_samples_bqm(
            (values, list(self.bqm.variables)), self.bqm, info=info
        )


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
