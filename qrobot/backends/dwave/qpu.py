"""D-Wave's quantum annealers: any model, embedded by EmbeddingComposite into the working graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import dimod
import numpy as np

from qrobot.backends.dwave.client import DWaveCloudSampler, opened
from qrobot.backends.sampler import COMMON, Parameter
from qrobot.errors import BackendError
from qrobot.jobs import LIMITS, Answer, Estimate, Keep, RemoteJob

__all__ = ["DWaveQPUSampler"]

EMBEDDING_SECONDS = 60
"""Longest search for an embedding; minorminer's own default is 1000."""

CHAINS = 1.0
"""Chain strength of picking models in units of the SDK's (whose own prefactor is 1.414).
Measured with simulated annealing on an embedded graph, not on a QPU: docs/stacks/dwave.md."""


METHODS = ("majority_vote", "weighted_random", "discard")
"""How a broken chain is read."""


class DWaveQPUSampler(DWaveCloudSampler):
    """A D-Wave quantum annealer. Work units: reads.

    The embedding is found here, kept with the job, and used to read the answer, be it in
    another process. ``info["embedding"]`` of the samples reports the qubits, the longest
    chain, the chain strength and the mean share of broken chains; each row's own share is
    in ``record.chain_break_fraction``.

    Parameters
    ----------
    child
        A structured sampler, such as ``DWaveSampler`` or ``MockDWaveSampler``.
    **config
        For ``DWaveSampler``, such as ``profile``.
    """

    name = "dwave-qpu"
    title = "D-Wave QPU"
    accepts: Mapping[str, Parameter] = {
        "num_reads": COMMON["num_reads"],
        "seed": COMMON["seed"],
        "device": Parameter("text", also=(Mapping,)),
        "annealing_time": Parameter("number", 0, above=True),
        "anneal_schedule": Parameter("pairs"),
        "answer_mode": Parameter("choice", choices=("histogram", "raw")),
        "chain_strength": Parameter("number", 0, above=True, also=(Mapping, Callable)),
        "chain_break_method": Parameter("choice", choices=METHODS, also=(Callable,)),
        "embedding_parameters": Parameter("names"),
        "fast_anneal": Parameter("flag"),
        "programming_thermalization": Parameter("number", 0),
        "readout_thermalization": Parameter("number", 0),
        "reduce_intersample_correlation": Parameter("flag"),
        **LIMITS,
    }

    def __init__(self, child: Any = None, **config: Any) -> None:
        super().__init__(child, **config)
        self._known: tuple[Any, dict[Any, tuple[int, ...]]] | None = None

    def make_child(self, config: dict[str, Any]) -> Any:
        """Return a ``DWaveSampler``."""
        from dwave.system import DWaveSampler

        return opened(DWaveSampler, config)

    def picking_defaults(self, *, largest_distance: float) -> dict[str, Any]:
        """Return reads and chains that suit picking models."""
        del largest_distance
        return {"num_reads": 1000, "chain_strength": _chains}

    def embed(
        self, bqm: dimod.BinaryQuadraticModel, seed: int | None = None, **parameters: Any
    ) -> dict[Any, tuple[int, ...]]:
        """Return qubits for each variable.

        Raises
        ------
        BackendError
            When the model does not fit on the device.
        """
        import minorminer

        child = self.connect()
        qubits = len(child.nodelist)
        if bqm.num_variables > qubits:
            raise BackendError(
                f"the model has {bqm.num_variables} variables, {self.device_name()} has {qubits}"
                " qubits; use backend leap-bqm, or plan fewer items at a time"
            )
        edges = [*bqm.quadratic, *((v, v) for v in bqm.variables)]
        key = (self._device, frozenset(edges), seed, repr(sorted(parameters.items())))
        if self._known is not None and self._known[0] == key:
            return self._known[1]
        longest = min(EMBEDDING_SECONDS, self._limit or EMBEDDING_SECONDS, self._left())
        chosen = {"timeout": longest, "random_seed": seed} | parameters
        chosen = {name: value for name, value in chosen.items() if value is not None}
        found = minorminer.find_embedding(edges, child.edgelist, **chosen)
        if not found:
            raise BackendError(
                f"no embedding of {bqm.num_variables} variables and {bqm.num_interactions}"
                f" couplings into {self.device_name()} ({qubits} qubits) was found; use backend"
                " leap-bqm, plan fewer items at a time, or give another seed"
            )
        embedding = {v: tuple(int(q) for q in chain) for v, chain in found.items()}
        self._known = (key, embedding)
        return embedding

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what a job would cost, by the timing model that the solver publishes."""
        child = self.connect(parameters.get("device"))
        embedding = self.embed(
            bqm, parameters.get("seed"), **(parameters.get("embedding_parameters") or {})
        )
        if not child.properties.get("problem_timing_data"):
            return Estimate(None, None, f"{self.device_name()} publishes no timing model")
        from dwave.cloud.solver import StructuredSolver

        about = {
            name: parameters[name]
            for name in (
                "num_reads", "annealing_time", "anneal_schedule", "programming_thermalization",
                "readout_thermalization", "reduce_intersample_correlation",
            )
            if parameters.get(name) is not None
        }  # fmt: skip
        microseconds = StructuredSolver.estimate_qpu_access_time(
            SimpleNamespace(properties=child.properties), sum(map(len, embedding.values())), **about
        )
        return self.usd(float(microseconds) / 1e6, "QPU access")

    def submit(
        self, bqm: dimod.BinaryQuadraticModel, *, label: str, keep: Keep, **parameters: Any
    ) -> tuple[str, str]:
        """Embed a model and hand it over."""
        from dwave.embedding import EmbeddedStructure
        from dwave.system import EmbeddingComposite

        child = self.connect(parameters.pop("device", None))
        embedding = self.embed(
            bqm,
            parameters.pop("seed", None),
            **(parameters.pop("embedding_parameters", None) or {}),
        )
        structure = EmbeddedStructure(child.edgelist, embedding)
        method = parameters.pop("chain_break_method", None)
        numbers = {v: i for i, v in enumerate(bqm.variables)}

        def before(strength: Any) -> None:
            context = {
                "embedding": [[numbers[v], list(chain)] for v, chain in embedding.items()],
                "chain_strength": _plain_strength(strength),
                "chain_break_method": method if isinstance(method, str) else None,
            }
            keep({"dwave": context})

        tap = _tap(child, lambda: before(getattr(structure, "chain_strength", None)))
        composite = EmbeddingComposite(tap, find_embedding=lambda *_, **__: structure)
        given = {name: value for name, value in parameters.items() if value is not None}
        if isinstance(method, str):
            method = _method(method)
        if "label" in child.parameters:
            given["label"] = label
        composite.sample(bqm, chain_break_method=method, **given)
        return self.id_and_device(tap.sent)

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the samples, chains resolved, with the energies of the submitted model."""
        from dwave.embedding import unembed_sampleset

        answer = self.raw_answer(job)
        bqm = job.bqm()
        kept = job.context["dwave"]
        names = list(bqm.variables)
        embedding = {names[i]: tuple(chain) for i, chain in kept["embedding"]}
        raw = answer.samples.change_vartype(bqm.vartype, inplace=False)
        info = dict(answer.samples.info)
        method = kept.get("chain_break_method")
        samples = unembed_sampleset(
            raw,
            embedding,
            bqm,
            chain_break_method=_method(method) if method else None,
            chain_break_fraction=True,
        )
        broken = samples.record.chain_break_fraction
        times = samples.record.num_occurrences
        info["embedding"] = {
            "qubits": sum(map(len, embedding.values())),
            "longest_chain": max(map(len, embedding.values())),
            "chain_strength": kept["chain_strength"],
            "chain_break_fraction": float(np.average(broken, weights=times))
            if len(samples)
            else 0.0,
        }
        samples.info.clear()
        samples.info.update(info)
        answer.samples = samples
        return answer


def _chains(bqm: dimod.BinaryQuadraticModel, embedding: Any = None) -> float:
    """Return the SDK's uniform torque compensation, times `CHAINS`."""
    from dwave.embedding.chain_strength import uniform_torque_compensation

    return float(uniform_torque_compensation(bqm, embedding, prefactor=CHAINS))


def _method(name: str) -> Any:
    from dwave.embedding import chain_breaks

    if name not in METHODS:  # of a job that was kept by another version
        raise BackendError(f"{name!r} resolves no chains; use one of {', '.join(METHODS)}")
    return getattr(chain_breaks, name)


def _plain_strength(strength: Any) -> Any:
    """Return a chain strength as plain data: a number, or the range of one for each chain."""
    if isinstance(strength, Mapping):
        values = [float(value) for value in strength.values()]
        return {"least": min(values), "largest": max(values)} if values else None
    return None if strength is None else float(strength)


def _tap(child: Any, before: Any) -> Any:
    """Return a structured sampler that passes on to another and remembers what it sent."""

    class Tap(dimod.Sampler, dimod.Structured):
        nodelist = child.nodelist
        edgelist = child.edgelist
        parameters = child.parameters
        properties = child.properties
        sent: dimod.SampleSet

        def sample(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> dimod.SampleSet:
            before()
            self.sent = child.sample(bqm, **parameters)
            return self.sent

    return Tap()
