"""Small states take one thread, in the libraries and in Aer."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from qrobot.backends.gate import constrained
from qrobot.backends.gate.resources import PARALLEL, few_threads
from qrobot.backends.gate.sampler import VariationalSampler


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info()}


def test_small_states_take_one_thread_and_give_the_others_back() -> None:
    _ = np.eye(2) @ np.eye(2)  # its linear algebra is loaded
    with threadpool_limits(limits=2):
        before = threads()
        with few_threads(PARALLEL - 1):
            assert threads() == {1}
        assert threads() == before
        with few_threads(PARALLEL):
            assert threads() == before


def test_every_variational_sampler_works_within_it(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[set[int]] = []

    class Sampler(VariationalSampler):
        sdk = extra = "none"
        algorithm = "vqe"

        def check(self, qubits, options):
            return True

        def engine(self, circuit, options):
            from qrobot.backends.gate.engine import PlainEngine

            seen.append(threads())
            return PlainEngine(circuit)

    with threadpool_limits(limits=2):
        bqm = dimod.BinaryQuadraticModel({0: 1.0, 1: -1.0}, {}, 0.0, "BINARY")
        Sampler().sample(bqm, num_reads=5, evaluations=2, seed=0)
    assert seen == [{1}]


def test_aer_has_threads_only_for_large_states() -> None:
    pytest.importorskip("qiskit_aer")
    from qrobot.backends.qiskit.sampler import _threaded

    assert _threaded({}, PARALLEL - 1) == {"max_parallel_threads": 1}
    assert _threaded({}, PARALLEL) == {}
    assert _threaded({"max_parallel_threads": 3}, 4) == {"max_parallel_threads": 3}


@pytest.mark.parametrize("name", ["statevector", "qiskit-vqe", "pennylane-vqe", "braket-vqe"])
def test_libraries_that_come_with_a_device_are_held_too(name: str) -> None:
    """Lightning and Aer bring an OpenMP of their own, which is loaded with the device."""
    sdk = {"qiskit": "qiskit_aer", "pennylane": "pennylane_lightning", "braket": "braket.devices"}
    if name != "statevector":
        pytest.importorskip(sdk[name.partition("-")[0]])
    from qrobot.backends import get

    bqm = dimod.BinaryQuadraticModel(dict.fromkeys(range(4), 1.0), {(0, 1): 1.0}, 0.0, "BINARY")
    seen: list[set[int]] = []
    with threadpool_limits(limits=2):
        get(name).sample(
            bqm,
            num_reads=1,
            evaluations=3,
            seed=0,
            interrupt_function=lambda: seen.append(threads()),
        )
    assert seen[0] == {1}


@pytest.mark.parametrize("name", ["qaoa-swap", "qaoa-grover"])
def test_circuits_that_keep_the_plans_take_one_thread(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from oracles import paper_shaped

    from qrobot.backends import Stop, get

    seen: list[set[int]] = []
    sharpen = constrained.sharpen

    def watched(*given, **named):
        seen.append(threads())
        return sharpen(*given, **named)

    monkeypatch.setattr(constrained, "sharpen", watched)
    with threadpool_limits(limits=2):
        get(name).search(paper_shaped(3, 1, 0), stop=Stop(max_work=4))
    assert seen == [{1}]
