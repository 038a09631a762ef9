"""The sampler that the three SDKs share: search parameters, then measure, and say both."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import dimod
import numpy as np

from qrobot.backends.base import Capabilities
from qrobot.backends.gate import resources
from qrobot.backends.gate.ansatz import Ansatz, make_ansatz
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import Engine, PlainEngine, RemoteEngine, StateEngine, room
from qrobot.backends.gate.form import Form, terms
from qrobot.backends.gate.resources import few_threads
from qrobot.backends.gate.search import SEARCH, Options, ParameterSearch, facts_of, ground, lengths
from qrobot.backends.sampler import (
    Parameter,
    PickingSampler,
    check_finite,
    check_parameters,
    constant_samples,
    samples_of_bits,
)
from qrobot.errors import BackendError, QRobotError, RemoteError
from qrobot.jobs import LIMITS, Estimate, JobOptions, check_budget, redact, with_retries
from qrobot.jobs.cost import FREE, together
from qrobot.jobs.samples import empty

__all__ = ["VariationalSampler"]


class VariationalSampler(PickingSampler):
    """Searches a circuit's parameters and samples its final state.

    Reads are measured shots as they come: nothing is repaired or selected. The sample set's
    `info` holds ``parameters`` (to resume from), ``objective``, ``history`` (the objective of
    each evaluation), ``evaluations``, ``searches`` (evaluations of each start),
    ``executions`` (circuits run), ``ansatz``, ``layers``,
    ``alpha``, ``optimizer``, ``device``, ``trained``, ``qubits``, ``seed``, ``timing`` in
    seconds and, where probabilities are exact, ``ground_energy``, ``ground_probability`` and
    the control ``ground_probability_uniform``.

    On a machine that is reached over a network each run is a job (`qrobot.jobs.run_job`):
    ``info["remote"]`` tells of the one with the reads, ``info["search"]`` of those of a search
    with ``train="device"``. Local devices bill nothing, and the limits of a job's life do
    nothing there.
    """

    sdk: ClassVar[str]
    algorithm: ClassVar[str]
    own: ClassVar[Mapping[str, Parameter]] = {}
    """The options that only this SDK has."""

    properties: ClassVar[dict[str, Any]] = {}

    def __init__(self) -> None:
        self.name = f"{self.sdk}-{self.algorithm}"
        search = {k: v for k, v in SEARCH.items() if (k, self.algorithm) != ("ansatz", "qaoa")}
        self.accepts = {**search, **self.own, **LIMITS}
        # No largest size: the device and the memory decide, before anything is allocated.
        self.capabilities = Capabilities(kind="sampler")

    @abstractmethod
    def check(self, qubits: int, options: Options) -> bool:
        """Refuse what the device cannot do, before anything is allocated.

        Returns
        -------
        bool
            Whether the device is local (nothing is billed).

        Raises
        ------
        MissingExtraError
            When the SDK is absent.
        BackendError
            When there are too many qubits, or the device was retired.
        """

    @abstractmethod
    def engine(self, circuit: Circuit, options: Options) -> Engine:
        """Return a local device, ready to run a circuit."""

    def connect(self, qubits: int, options: Options, job_options: JobOptions) -> Any:
        """Return a remote device that can hold so many qubits; nothing is billed.

        For SDKs whose `check` ever says that a device is remote.

        Raises
        ------
        CredentialsError, RemoteError
            When the service cannot be reached.
        BackendError
            When the model does not fit, or the device takes no jobs.
        """
        raise NotImplementedError

    def remote_engine(self, machine: Any, circuit: Circuit, options: Options) -> RemoteEngine:
        """Return a device of `connect`, ready to run a circuit."""
        raise NotImplementedError

    def sample(self, bqm: Any, **parameters: Any) -> dimod.SampleSet:
        """Sample a binary quadratic model.

        Parameters
        ----------
        bqm
            Any binary quadratic model.
        **parameters
            As of `Options`; those of a remote job's life are in `qrobot.jobs.JobOptions`.

        Raises
        ------
        InputError
            When an option is unknown or out of range, or the model holds NaN.
        BackendError
            When the model does not fit, would cost too much, or the device fails.
        """
        options, job_options = self._asked(parameters)
        if not self.check(bqm.num_variables, options) and bqm.num_variables:
            return self._sample_remotely(bqm, options, job_options)
        check_budget(FREE, job_options.max_cost)
        if job_options.dry_run:
            return _estimated(bqm, FREE)
        if not bqm.num_variables:
            return constant_samples(bqm, int(options.num_reads))
        try:
            with few_threads(bqm.num_variables):
                return self._sample_here(bqm, options)
        except QRobotError:
            raise
        except Exception as error:  # each SDK has errors of its own, for options of its own too
            text = redact(f"{type(error).__name__}: {error}")
            raise BackendError(f"backend {self.name} failed: {text}") from error

    def runs_remotely(self, **parameters: Any) -> bool:
        """Return whether `sample` with these parameters asks another machine."""
        try:
            options, _ = self._asked(dict(parameters))
            return not self.check(1, options)
        except QRobotError:
            return True  # `sample` says why; until then an SDK's error may hold a secret

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what `sample` with these parameters would cost; submits nothing.

        Raises
        ------
        InputError, BackendError
            As `sample`, which refuses the same.
        """
        options, job_options = self._asked(parameters)
        check_finite(bqm)
        if self.check(bqm.num_variables, options) or not bqm.num_variables:
            return FREE
        return self._prepared(bqm, options, job_options)[2]

    def _asked(self, parameters: dict[str, Any]) -> tuple[Options, JobOptions]:
        """Return the options of the search and of a remote job."""
        check_parameters(self, parameters)
        own = {name: parameters.pop(name) for name in self.own if name in parameters}
        job_options = JobOptions.take_from(parameters)
        if self.algorithm == "qaoa":
            parameters["ansatz"] = "qaoa"
        interrupted = job_options.interrupt_function
        return Options(**parameters, own=own, interrupt_function=interrupted), job_options

    def _search(self, bqm: Any, options: Options) -> tuple[ParameterSearch, int]:
        seed = _fresh() if options.seed is None else int(options.seed)
        form = Form.from_bqm(bqm)
        ansatz = make_ansatz(options.ansatz, form, terms(bqm), options.layers)
        return ParameterSearch(self.algorithm, options, form, ansatz, seed), seed

    def _sample_here(self, bqm: Any, options: Options) -> dimod.SampleSet:
        clock = [time.perf_counter()]
        search, seed = self._search(bqm, options)
        engine = self.engine(search.ansatz.circuit, options)
        here = options.train != "local" or options.evaluations == 0
        trainer = engine if here else _trainer(search.ansatz)
        clock.append(time.perf_counter())
        found = search.run(trainer)
        clock.append(time.perf_counter())
        angles = search.ansatz.circuit.angles(found.parameters)
        reads = int(options.num_reads)
        if _interrupted(options):  # a part of them is quick, and better than nothing
            reads = -(-reads // 4)
        with few_threads(search.form.qubits):
            bits = engine.samples(angles, reads, search.draw)
        clock.append(time.perf_counter())
        info = facts_of(search, seed, engine, trainer, found)
        info["timing"] = lengths(("build", "optimise", "sample"), clock)
        if reads < options.num_reads:
            info["cut"] = (
                f"the time for sampling was over: the search for parameters ended after "
                f"{info['evaluations']} runs, and {reads} of {options.num_reads} reads were taken"
            )
        if isinstance(engine, StateEngine) and search.energies is not None:
            info |= ground(engine.probabilities(angles), search.energies)
        return samples_of_bits(bqm, bits, info)

    def _prepared(
        self, bqm: Any, options: Options, job_options: JobOptions
    ) -> tuple[tuple[ParameterSearch, int], RemoteEngine, Estimate]:
        """Return the search, the machine and what both together would cost at most."""
        qubits, trains = bqm.num_variables, options.evaluations != 0
        if trains and options.train != "device":
            _room_to_train(qubits)
        machine = self.connect(qubits, options, job_options)
        resources.require(32 * qubits**2, f"the couplings of {qubits} qubits")
        search, seed = self._search(bqm, options)
        # A machine may be asked for what circuits are made for, so this is a call to a service.
        engine = with_retries(
            lambda: self.remote_engine(machine, search.ansatz.circuit, options),
            what=f"backend {self.name}",
            backoff=job_options.backoff,
            stop=job_options.interrupt_function,
        )
        engine.begin(self.name, bqm, job_options)
        estimate = engine.cost(int(options.num_reads))
        if trains and options.train == "device":
            runs = search.measured()
            parts = {"search": engine.cost(search.shots, runs), "reads": estimate}
            estimate = together(parts)
        return (search, seed), engine, estimate

    def _sample_remotely(
        self, bqm: Any, options: Options, job_options: JobOptions
    ) -> dimod.SampleSet:
        clock = [time.perf_counter()]
        (search, seed), engine, estimate = self._prepared(bqm, options, job_options)
        if job_options.dry_run:
            return _estimated(bqm, estimate)
        check_budget(estimate, job_options.max_cost)
        here = options.train == "device" or options.evaluations == 0
        trainer = engine if here else _trainer(search.ansatz)
        clock.append(time.perf_counter())
        found = search.run(trainer)
        clock.append(time.perf_counter())
        if _interrupted(options):
            raise RemoteError(
                f"backend {self.name}: interrupted before the reads were handed to {engine.title}"
            )
        info = facts_of(search, seed, engine, trainer, found)
        info["executions"] += 1  # the reads, told before they run: other processes read it too
        info["timing"] = lengths(("build", "optimise"), clock)
        if engine.trainings:
            info["search"] = {
                "jobs": engine.trainings,
                "timing": engine.training,
                "estimate": estimate.to_dict(),
            }
        angles = search.ansatz.circuit.angles(found.parameters)
        samples = engine.reads(angles, int(options.num_reads), info)
        if not len(samples):  # not waited for: the parameters are known all the same
            samples.info.update(info)
        return samples


def _estimated(bqm: Any, estimate: Estimate) -> dimod.SampleSet:
    return empty(bqm, {"dry_run": True, "estimate": estimate.to_dict()})


def _interrupted(options: Options) -> bool:
    return options.interrupt_function is not None and options.interrupt_function()


def _room_to_train(qubits: int) -> None:
    room(
        qubits,
        "this machine, where parameters are searched",
        "use train='device', or evaluations=0 with initial_parameters",
    )


def _trainer(ansatz: Ansatz) -> Engine:
    _room_to_train(ansatz.circuit.qubits)
    return PlainEngine(ansatz.circuit)


def _fresh() -> int:
    return int(np.random.SeedSequence().generate_state(1)[0])
