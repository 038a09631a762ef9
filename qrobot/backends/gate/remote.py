"""Circuits on machines that are reached over a network: each run is a job of its own."""

from __future__ import annotations

import time
from abc import abstractmethod
from dataclasses import replace
from typing import Any

import dimod
import numpy as np

from qrobot._arrays import Bits, Floats
from qrobot.backends.gate.engine import Engine
from qrobot.errors import RemoteError
from qrobot.jobs import Estimate, JobOptions, run_job
from qrobot.jobs.circuits import CircuitJobs
from qrobot.jobs.samples import PARTS

__all__ = ["JobEngine", "RemoteEngine"]


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
