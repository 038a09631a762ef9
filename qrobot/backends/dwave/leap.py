"""The hybrid solvers of D-Wave Leap, for models beyond the QPU's working graph."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import dimod
import numpy as np

from qrobot.backends.dwave.client import DWaveCloudSampler, answered, opened
from qrobot.backends.sampler import Parameter, samples_of_bits
from qrobot.errors import InputError
from qrobot.jobs import LIMITS, Answer, Estimate, Keep, RemoteJob

__all__ = ["LeapBQMSampler", "LeapCQMSampler", "LeapNLSampler"]


class LeapBQMSampler(DWaveCloudSampler):
    """The hybrid solver of binary quadratic models. Work unit: one answer."""

    name = "leap-bqm"
    title = "D-Wave Leap hybrid BQM"
    accepts: Mapping[str, Parameter] = {
        "time_limit": Parameter("number", 0, above=True),
        "device": Parameter("text", also=(Mapping,)),
        **LIMITS,
    }

    def make_child(self, config: dict[str, Any]) -> Any:
        """Return a ``LeapHybridSampler``."""
        from dwave.system import LeapHybridSampler

        return opened(LeapHybridSampler, config)

    def model(self, bqm: dimod.BinaryQuadraticModel) -> Any:
        """Return the model in the form that the solver takes."""
        return bqm

    def least_seconds(self, model: Any) -> float:
        """Return the least time limit of a model."""
        return float(self._child.min_time_limit(model))

    def seconds(self, model: Any, time_limit: float | None) -> float:
        """Return the seconds that a job will run and bill.

        Raises
        ------
        InputError
            When the limit is below the least that the solver allows.
        """
        least = self.least_seconds(model)
        if time_limit is None:
            return least
        if time_limit < least:
            raise InputError(
                f"a time limit of {time_limit:g} s is below the solver's least of {least:.3g} s",
                field="time_limit",
                advice="give more, or leave it out",
            )
        return float(time_limit)

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what a job would cost: it bills its time limit."""
        self.connect(parameters.get("device"))
        seconds = self.seconds(self.model(bqm), parameters.get("time_limit"))
        return self.usd(seconds, "hybrid solver")

    def submit(
        self, bqm: dimod.BinaryQuadraticModel, *, label: str, keep: Keep, **parameters: Any
    ) -> tuple[str, str]:
        """Upload a model and hand it over."""
        del keep
        self.connect(parameters.get("device"))
        model = self.model(bqm)
        limit = self.seconds(model, parameters.get("time_limit"))
        return self.id_and_device(self.send(model, limit, label))

    def send(self, model: Any, time_limit: float, label: str) -> dimod.SampleSet:
        """Submit a model to the solver; the samples are not there yet."""
        return self._child.sample(model, time_limit=time_limit, label=label)

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the samples with the labels and the energies of the submitted model."""
        answer = self.raw_answer(job)
        answer.samples = fitted(answer.samples, job.bqm())
        return answer


class LeapCQMSampler(LeapBQMSampler):
    """The hybrid solver of constrained quadratic models, given a model without constraints.

    `sample` takes any binary quadratic model, so that all samplers can be compared; a model
    with constraints of its own goes to ``connect().sample_cqm``.
    """

    name = "leap-cqm"
    title = "D-Wave Leap hybrid CQM"

    def make_child(self, config: dict[str, Any]) -> Any:
        """Return a ``LeapHybridCQMSampler``."""
        from dwave.system import LeapHybridCQMSampler

        return opened(LeapHybridCQMSampler, config)

    def model(self, bqm: dimod.BinaryQuadraticModel) -> Any:
        """Return the model as the objective of a constrained one."""
        return dimod.ConstrainedQuadraticModel.from_bqm(bqm)

    def send(self, model: Any, time_limit: float, label: str) -> dimod.SampleSet:
        """Submit a model to the solver; the samples are not there yet."""
        return self._child.sample_cqm(model, time_limit=time_limit, label=label)


def fitted(samples: dimod.SampleSet, bqm: dimod.BinaryQuadraticModel) -> dimod.SampleSet:
    """Return samples with the labels, the vartype and the energies of a model.

    Large models travel without labels, and solvers may round energies.
    """
    names = list(samples.variables)
    if set(names) != set(bqm.variables):
        own = list(bqm.variables)
        names = [own[int(name)] for name in names]
    values = samples.record.sample
    low = -1 if bqm.vartype is dimod.SPIN else 0
    values = values.copy()
    values[values <= 0] = low
    return dimod.SampleSet.from_samples_bqm(
        (values, names),
        bqm,
        num_occurrences=samples.record.num_occurrences,
        info=dict(samples.info),
    )


class LeapNLSampler(LeapBQMSampler):
    """The hybrid solver of nonlinear models. Work unit: one answer.

    `sample` takes any binary quadratic model, so that all samplers can be compared; a model
    with lists or sets of its own goes to ``connect().sample``.
    """

    name = "leap-nl"
    title = "D-Wave Leap hybrid nonlinear"

    def make_child(self, config: dict[str, Any]) -> Any:
        """Return a ``LeapHybridNLSampler``."""
        from dwave.system import LeapHybridNLSampler

        return opened(LeapHybridNLSampler, config)

    def model(self, bqm: dimod.BinaryQuadraticModel) -> Any:
        """Return the model in nonlinear form."""
        return nonlinear_model(bqm)[0]

    def least_seconds(self, model: Any) -> float:
        """Return the least time limit of a model."""
        return float(self._child.estimated_min_time_limit(model))

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the states as samples of the submitted model."""
        bqm, future = job.bqm(), self.future(job)
        model, decisions = nonlinear_model(bqm)
        model.lock()
        # As the SDK does: the header of an answer differs from that of the model.
        model.states.from_file(future.answer_data, check_header=False)
        rows = [np.asarray(decisions.state(k)) for k in range(model.states.size())]
        bits = np.asarray(rows, dtype=np.int8).reshape(len(rows), bqm.num_variables)
        info = {"timing": dict(future.timing), "problem_id": job.remote_id}
        return answered(samples_of_bits(bqm, bits, info), future)


def nonlinear_model(bqm: dimod.BinaryQuadraticModel) -> tuple[Any, Any]:
    """Return a ``dwave.optimization.Model`` of a BQM, and its decision symbol.

    Its objective is the energy less the constant of the binary form.
    """
    from dwave.optimization import Model

    binary = bqm.binary
    labels = list(binary.variables)
    numbers = {v: i for i, v in enumerate(labels)}
    model = Model()
    decisions = model.binary(len(labels))
    linear = {numbers[v]: float(bias) for v, bias in binary.linear.items()}
    quadratic = {(numbers[u], numbers[v]): float(b) for (u, v), b in binary.quadratic.items()}
    model.minimize(model.quadratic_model(decisions, quadratic, linear))
    return model, decisions
