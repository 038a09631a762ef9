"""Leap's nonlinear hybrid solver, given a binary quadratic model."""

from __future__ import annotations

from typing import Any

import dimod

from qrobot.backends.dwave.jobs import opened, run_seconds, seconds_of
from qrobot.backends.dwave.leap import LeapBQMSampler
from qrobot.errors import RemoteError
from qrobot.jobs import Answer, RemoteJob

__all__ = ["LeapNLSampler", "nonlinear_model"]


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
        import numpy as np

        if self.jobs is None:
            raise RemoteError(f"{self.title} job {job.id} is gone with the mock that ran it")
        bqm = job.bqm()
        future = self.jobs.client.retrieve_answer(job.remote_id)
        model, decisions = nonlinear_model(bqm)
        model.lock()
        # As the SDK does: the header of an answer differs from that of the model.
        model.states.from_file(future.answer_data, check_header=False)
        rows = [np.asarray(decisions.state(k)) for k in range(model.states.size())]
        bits = np.asarray(rows, dtype=np.int8).reshape(len(rows), bqm.num_variables)
        values = 2 * bits - 1 if bqm.vartype is dimod.SPIN else bits
        info = {"timing": dict(future.timing), "problem_id": job.remote_id}
        samples = dimod.SampleSet.from_samples_bqm((values, list(bqm.variables)), bqm, info=info)
        return Answer(
            samples,
            run=run_seconds(info),
            received=seconds_of(future.time_received),
            solved=seconds_of(future.time_solved),
        )


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
