"""What a device has to do: run a circuit with given angles, one a rotation.

A device that is reached over a network runs it within limits of time and money, each run a job.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import dimod
import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot.backends.gate import resources
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.form import bits_of
from qrobot.backends.gate.state import general
from qrobot.errors import BackendError, QRobotError, RemoteError
from qrobot.jobs import Estimate, JobOptions, run_job
from qrobot.jobs.circuits import CircuitJobs
from qrobot.jobs.retry import classify, translate
from qrobot.jobs.samples import PARTS

__all__ = [
    "Engine",
    "JobEngine",
    "PlainEngine",
    "RemoteEngine",
    "StateEngine",
    "attempt",
    "check_size",
    "room",
    "shift",
]


T = TypeVar("T")


BYTES = 96
"""Of an amplitude: the state and two copies (16 each), its energy and five numbers (8 each)."""


def room(qubits: int, where: str, advice: str = "use a smaller model or a remote device") -> None:
    """Refuse a state that memory cannot hold, before any of it is taken.

    Raises
    ------
    BackendError
        With the number of qubits and the memory that they need.
    """
    what = f"a state of {qubits} qubits on {where}"
    resources.require(BYTES << qubits, what, advice, qubits=qubits)


def check_size(qubits: int, most: int | None, device: str) -> None:
    """Refuse a model with more qubits than a device has.

    Raises
    ------
    BackendError
        With both numbers.
    """
    if most is not None and qubits > most:
        raise BackendError(
            f"the model needs {qubits} qubits and device {device} has {most}; "
            "use a smaller model or a larger device"
        )


def attempt(name: str, doing: str, call: Callable[[], T]) -> T:
    """Call an SDK; refuse with the kind of its error, never with a chain to it.

    Texts of SDKs may quote a token or a signed address. Only what a service answers, or that
    it does not, is told with the text, which `translate` redacts.

    Parameters
    ----------
    name, doing
        Of the backend, and what it does, for the message.
    call
        The call.

    Raises
    ------
    CredentialsError, RemoteError
        When a service refused the credentials, cannot be reached, or is late.
    BackendError
        When the call fails otherwise; errors of ours pass.
    """
    try:
        return call()
    except QRobotError:
        raise
    except Exception as error:
        kind = type(error).__name__
        told = None if classify(error) == "final" else translate(error, f"backend {name}")
    if told is not None:
        raise told
    raise BackendError(f"backend {name}: {doing} failed ({kind})")


class Engine(ABC):
    """A circuit on a device.

    Parameters
    ----------
    circuit
        What it runs; counted in `executions`, with anything worth reporting in `facts`.
    """

    gradients = False
    """Whether derivatives cost much less than two runs a rotation."""

    def __init__(self, circuit: Circuit) -> None:
        self.circuit = circuit
        self.executions = 0
        self.facts: dict[str, Any] = {}

    @abstractmethod
    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots, shape (shots, qubits); column k is variable k."""


class StateEngine(Engine):
    """A device that gives exact probabilities."""

    @abstractmethod
    def probabilities(self, angles: Floats) -> Floats:
        """Return the probabilities of all assignments; bit k of an index is variable k."""

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Draw shots from the exact probabilities."""
        upto = np.cumsum(np.maximum(self.probabilities(angles), 0.0))
        draws = np.random.default_rng(seed).random(shots) * upto[-1]
        found = np.minimum(np.searchsorted(upto, draws, side="right"), upto.size - 1)
        return bits_of(found, self.circuit.qubits)

    def slope(self, angles: Floats, weights: Floats) -> tuple[float, Floats]:
        """Return the mean of a diagonal observable and its derivatives by the angles.

        Here by two runs a rotation; devices that know better override it.
        """
        return (
            float(self.probabilities(angles) @ weights),
            shift(lambda at: float(self.probabilities(at) @ weights), angles),
        )


class PlainEngine(StateEngine):
    """Numpy alone: trains parameters for remote devices, and what the SDKs are held against."""

    gradients = True

    def probabilities(self, angles: Floats) -> Floats:
        """Return the probabilities of all assignments."""
        self.executions += 1
        found: Floats = np.abs(general.state(self.circuit, angles)) ** 2
        return found

    def slope(self, angles: Floats, weights: Floats) -> tuple[float, Floats]:
        """Return the mean and its derivatives, by one run forward and one backward."""
        self.executions += 1
        return general.gradient(self.circuit, angles, weights)


def shift(mean: Any, angles: Floats) -> Floats:
    """Return derivatives by the parameter-shift rule, exact for rotations exp(-i angle P / 2).

    M. Schuld et al., Physical Review A 99 (2019) 032331.
    """
    found = np.empty(angles.size)
    for k in range(angles.size):
        ahead, behind = angles.copy(), angles.copy()
        ahead[k] += np.pi / 2
        behind[k] -= np.pi / 2
        found[k] = (mean(ahead) - mean(behind)) / 2
    return found


class RemoteEngine(Engine):
    """Measured shots of a machine that is not ours. `begin` comes before the first run."""

    title = "the machine"
    """For messages."""

    def begin(self, backend: str, bqm: Any, job_options: JobOptions) -> None:
        """Say for whom circuits run, and within which limits of time and money."""
        self.backend, self.bqm, self.job_options = backend, bqm, job_options
        self.training: dict[str, float] = {}
        self.trainings = 0
        self._first: float | None = None

    @abstractmethod
    def cost(self, shots: int, runs: int = 1) -> Estimate:
        """Return what so many runs of the circuit would cost."""

    @abstractmethod
    def run(self, angles: Floats, shots: int, job_options: JobOptions) -> dimod.SampleSet:
        """Return one row a shot, over the variables of the model in their sequence."""

    def samples(self, angles: Floats, shots: int, seed: int) -> Bits:
        """Return measured shots of a search for parameters; the machine takes no seed."""
        del seed
        self.trainings += 1
        # The answer is needed for the next step, whatever is asked of the reads.
        found = self.run(angles, shots, replace(self.left(), wait=True, context={"part": "search"}))
        timing = found.info.get("remote", {}).get("timing", {})
        for part in PARTS:
            self.training[part] = self.training.get(part, 0.0) + timing.get(part, 0.0)
        columns = [found.variables.index(v) for v in self.bqm.variables]  # dimod sorts labels
        bits: Bits = (found.record.sample[:, columns] > 0).astype(np.int8)
        return bits

    def reads(self, angles: Floats, shots: int, info: dict[str, Any]) -> dimod.SampleSet:
        """Return the final reads.

        Parameters
        ----------
        angles, shots
            What to run, how often.
        info
            Plain data for the samples' info; kept beside the job for other processes.
        """
        job_options = self.left()
        return self.run(
            angles,
            shots,
            replace(job_options, context={**(job_options.context or {}), "info": info}),
        )

    def left(self) -> JobOptions:
        """Return the limits with what is left of the time: it counts from the first run.

        Raises
        ------
        RemoteError
            When nothing is left.
        """
        now = time.perf_counter()
        self._first = now if self._first is None else self._first
        whole = self.job_options.timeout
        if whole is None:
            return self.job_options
        rest = whole - (now - self._first)
        if rest <= 0:
            raise RemoteError(
                f"the search for parameters took longer than {whole:g} s; search with"
                " train='local', or give a longer timeout"
            )
        backoff = replace(self.job_options.backoff, timeout=rest)
        return replace(self.job_options, timeout=rest, backoff=backoff)


class JobEngine(RemoteEngine):
    """A machine whose runs are jobs: kept before they are sent, found again by their id."""

    @abstractmethod
    def jobs(self, angles: Floats, shots: int) -> CircuitJobs:
        """Return the job of one run, not started yet."""

    def run(self, angles: Floats, shots: int, job_options: JobOptions) -> dimod.SampleSet:
        """Submit one job and wait for it, as `job_options` says."""
        self.executions += 1
        return run_job(self.jobs(angles, shots), self.bqm, job_options)
