"""What a device has to do: run a circuit with given angles, one a rotation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot.backends.gate import resources
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.form import bits_of
from qrobot.backends.gate.state import general
from qrobot.errors import BackendError, QRobotError
from qrobot.jobs.retry import classify, translate

__all__ = ["Engine", "PlainEngine", "StateEngine", "attempt", "room"]

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
