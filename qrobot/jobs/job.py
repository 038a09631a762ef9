"""What is known about a remote job, as plain data that outlives the process."""

from __future__ import annotations

import secrets
import time
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from qrobot.errors import InputError

if TYPE_CHECKING:
    import dimod

__all__ = ["ENDED", "STATES", "Answer", "Estimate", "RemoteJob", "State", "pack_model"]

State = Literal["submitting", "queued", "running", "done", "failed", "cancelled"]

STATES: tuple[State, ...] = ("submitting", "queued", "running", "done", "failed", "cancelled")

ENDED: frozenset[State] = frozenset({"done", "failed", "cancelled"})
"""States that a job does not leave."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a job is expected to cost, before it is submitted.

    Parameters
    ----------
    usd
        US dollars; ``None`` when nobody can tell.
    seconds
        Billed seconds of the device; ``None`` when it does not bill by time.
    basis
        How it was reckoned, in words that a person can check.
    """

    usd: float | None
    seconds: float | None = None
    basis: str = ""

    def __str__(self) -> str:
        money = "unknown" if self.usd is None else f"{self.usd:.4g} USD"
        return f"{money} ({self.basis})" if self.basis else money

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {"usd": self.usd, "seconds": self.seconds, "basis": self.basis}


@dataclass(slots=True)
class Answer:
    """What a remote sampler fetched.

    Parameters
    ----------
    samples
        Resolved samples over the variables of the submitted model.
    run
        Seconds that the device itself worked, as the service tells; ``None``: not told.
    received, solved
        When the service took and finished the job, by its own clock, Unix seconds.
    """

    samples: dimod.SampleSet
    run: float | None = None
    received: float | None = None
    solved: float | None = None


def _new_id() -> str:
    return f"qr-{secrets.token_hex(6)}"


@dataclass(slots=True)
class RemoteJob:
    """A job on somebody else's machine.

    Parameters
    ----------
    backend
        Name of the backend that submitted it and can fetch it.
    id
        Our name of the job; it is also its label at the service.
    remote_id
        The service's name of the job; empty until the service has taken it.
    device
        Machine or solver.
    state
        One of `STATES`.
    submitted
        Unix seconds.
    variables
        Number of variables of the model.
    model
        The packed model (see `pack_model`); its labels decode the samples.
    context
        Plain data that fetching and decoding need: an embedding, the instance.
    timings
        Seconds of submit, latency, queue, run and return, once known.
    estimate
        What it was expected to cost.
    problem
        Why it failed, one sentence.
    """

    backend: str
    id: str = field(default_factory=_new_id)
    remote_id: str = ""
    device: str = ""
    state: State = "submitting"
    submitted: float = field(default_factory=time.time)
    variables: int = 0
    model: bytes = b""
    context: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    estimate: Estimate = field(default_factory=lambda: Estimate(None))
    problem: str = ""

    @property
    def ended(self) -> bool:
        """Whether the job is over, for good or bad."""
        return self.state in ENDED

    def bqm(self) -> dimod.BinaryQuadraticModel:
        """Return the submitted model with its labels."""
        import dimod

        return dimod.BinaryQuadraticModel.from_file(zlib.decompress(self.model))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data without the model and the context."""
        return {
            "id": self.id,
            "remote_id": self.remote_id,
            "backend": self.backend,
            "device": self.device,
            "state": self.state,
            "submitted": self.submitted,
            "variables": self.variables,
            "timings": dict(self.timings),
            "estimate": self.estimate.to_dict(),
            "problem": self.problem,
        }


def pack_model(bqm: dimod.BinaryQuadraticModel) -> bytes:
    """Return a model as compressed bytes.

    Raises
    ------
    InputError
        When a label is neither number nor text nor a tuple of them.
    """
    import dimod
    import numpy as np

    # A view (such as bqm.spin) or a model of Python objects cannot be written as it is.
    copy = dimod.BinaryQuadraticModel(bqm.vartype, dtype=np.float64)
    copy.add_linear_from(dict(bqm.linear))
    copy.add_quadratic_from(dict(bqm.quadratic))
    copy.offset = float(bqm.offset)
    try:
        with copy.to_file() as file:
            data = file.read()
        same = dimod.BinaryQuadraticModel.from_file(data).variables == copy.variables
    except (TypeError, ValueError):
        same = False
    if not same:
        raise InputError(
            "a label of the model cannot be kept with the job",
            field="bqm",
            advice="use numbers, texts or tuples of them as labels",
        )
    return zlib.compress(data, 6)
