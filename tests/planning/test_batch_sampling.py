"""Samplers that batch whole orders in aisles: the loop, its report, its control."""

from __future__ import annotations

from fractions import Fraction

import dimod
import numpy as np
import pytest

import qrobot
from qrobot import _jit
from qrobot.backends import Capabilities, Stop, get
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import InputError
from qrobot.jobs.cost import FREE
from qrobot.plan.checker import check
from qrobot.planning import estimate
from qrobot.planning.batch_sampling import wants_batches
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot

if not _jit.available():
    pytest.skip("numba is not installed", allow_module_level=True)

from qrobot.planning.neighbourhoods import Neighbourhoods
from qrobot.planning.proposals import BatchLoop, RandomSource
from qrobot.planning.tally import mean_distance


def whole_orders(count: int, robots: int, seed: int = 0, room: int = 9) -> Instance:
    """Return orders of three items each in two blocks of aisles."""
    rng = np.random.default_rng(seed)
    items = tuple(
        Item(f"i{k}", Fraction(1), Slot(*(int(v) for v in rng.integers((6, 8, 2)))))
        for k in range(3 * count)
    )
    return Instance(
        warehouse=AisleWarehouse(6, 8, 2),
        items=items,
        orders=tuple(
            Order(f"o{k}", tuple(f"i{3 * k + j}" for j in range(3))) for k in range(count)
        ),
        robots=tuple(Robot(f"R{k}", Fraction(room)) for k in range(robots)),
    )


class Zeros(PickingSampler):
    """A sampler that only ever says no: every plan is repair's work."""

    name = "neal"
    capabilities = Capabilities(kind="sampler")
    parameters = {"num_reads": [], "seed": []}  # noqa: RUF012
    properties = {}  # noqa: RUF012

    def sample(self, bqm, *, num_reads=1, seed=None):
        rows = np.zeros((num_reads, len(bqm.variables)), dtype=np.int8)
        return dimod.SampleSet.from_samples_bqm((rows, list(bqm.variables)), bqm)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["neal", "tabu", "descent"])
def test_a_sampler_batches_more_orders_than_sequences_allow(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("qrobot.planning.proposals.PARTS", 2)
    instance = whole_orders(12, 12)
    work = 10 + 20 + 6
    first = qrobot.solve(instance, backend=backend, max_work=work, seed=3)
    assert check(first.plan, instance).ok
    assert first.sampler is not None
    assert first.sampler.encoding == "batches"
    assert first.work[backend] == work
    parts = first.sampler.details["batches"]
    assert first.sampler.reads == parts["assignment"]["proposals"] == 10
    assert parts["neighbourhood"]["proposals"] == 20
    assert parts["selection"]["proposals"] == 6
    assert parts["neighbourhood"]["variables"] < parts["assignment"]["variables"]
    again = qrobot.solve(instance, backend=backend, max_work=work, seed=3)
    assert again.plan.to_dict() == first.plan.to_dict()
    assert again.sampler == first.sampler


def test_small_questions_get_the_best_plan() -> None:
    instance = whole_orders(6, 6, seed=4)
    best = qrobot.solve(instance, backend="exact", deadline=60)
    found = qrobot.solve(instance, backend="neal", encoding="batches", max_work=40)
    assert best.is_optimal
    assert found.cost == pytest.approx(best.cost)


def test_what_repair_did_is_not_the_samplers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: Zeros())
    instance = whole_orders(12, 12)
    result = qrobot.solve(instance, backend="neal", max_work=12, control=True)
    assert result.sampler is not None
    assert result.sampler.feasible_fraction == 0.0
    assert result.sampler.best is None
    assert result.sampler.polished_best == pytest.approx(result.cost)
    control = result.sampler.details["control"]
    parts = ("assignment", "neighbourhood", "selection")
    assert sum(control[part]["proposals"] for part in parts) == 12
    assert result.sampler.control_best is not None
    assert "no feasible read" in result.summary()
    assert "repair made plans of 11 of 12 proposals" in result.summary()


def test_the_loop_prices_by_exact_tours_and_counts_every_proposal() -> None:
    instance = whole_orders(10, 10, seed=1)
    kept: list[tuple[float, float]] = []
    loop = BatchLoop(
        instance,
        2,
        RandomSource(),
        lambda routes, length: kept.append((length, instance.length(routes))),
    )
    loop.run(Stop(max_work=25), reads=5)
    assert loop.work == 25
    assert loop.assignment.proposals + loop.neighbourhood.proposals == 25
    assert kept
    for told, measured in kept:
        assert told == pytest.approx(measured)
    assert loop.best == pytest.approx(min(loop.plans.values()))


def test_unequal_robots_and_a_tight_fleet() -> None:
    drawn = whole_orders(9, 4, seed=7)
    rooms = (12, 9, 6, 3)
    instance = qrobot.Instance(
        warehouse=drawn.warehouse,
        items=drawn.items,
        orders=drawn.orders,
        robots=tuple(Robot(f"R{k}", Fraction(room)) for k, room in enumerate(rooms)),
    )
    result = qrobot.solve(instance, backend="neal", encoding="batches", max_work=12)
    assert check(result.plan, instance).ok


def test_a_sampler_waits_for_no_compiler_where_it_can_do_without(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The example has 4,338 compact variables, which neal takes."""
    monkeypatch.setattr("qrobot._jit.is_cached", lambda *_: False)
    example = qrobot.read("examples/small-warehouse.json")
    assert not wants_batches(example, get("neal"), {}, Stop(5))
    assert wants_batches(example, get("neal"), {}, Stop())


def test_when_batches_are_sampled() -> None:
    neal = get("neal")
    large = whole_orders(12, 12)
    assert wants_batches(large, neal, {}, Stop())
    assert not wants_batches(large, neal, {"encoding": "compact"}, Stop())
    assert not wants_batches(whole_orders(4, 2), neal, {}, Stop())
    with pytest.raises(InputError, match="penalties of its own"):
        wants_batches(large, neal, {"encoding": "batches", "penalties": "safe"}, Stop())
    with pytest.raises(InputError, match="warehouse of aisles"):
        wants_batches(
            qrobot.read("examples/paper-4-items.json"), neal, {"encoding": "batches"}, Stop()
        )


def test_a_model_too_large_for_the_sampler_is_refused() -> None:
    with pytest.raises(InputError, match="binary variables"):
        BatchLoop(whole_orders(12, 12), 0, RandomSource(), variables=20)


@pytest.mark.parametrize("seed", range(5))
def test_a_neighbourhood_deals_out_whole_trips_and_its_fit_knows_them(seed: int) -> None:
    loop = BatchLoop(whole_orders(12, 12, seed=seed), seed, RandomSource())
    loop.run(Stop(max_work=10))
    plan = min(loop.plans, key=lambda p: (loop.plans[p], sorted(p)))
    found = Neighbourhoods(loop.orders, loop.surrogate, loop._length, loop.rng)
    for _ in range(5):
        part = found.draw(plan)
        batches = [frozenset(part.orders[group].tolist()) for group in part.groups]
        assert {frozenset(batch) for batch in plan} >= set(batches)
        assert part.groups.sum(axis=0).tolist() == [1] * len(part.orders)
        as_it_is = part.groups.argmax(axis=0)
        assert loop._batches(part.completed(as_it_is[None])[0]) == plan
        # The energy of the trips as they are is nearly their length: they are in the fit.
        model, _ = found.model(part)
        length = sum(loop._length(tuple(sorted(batch))) for batch in batches)
        assert model.bqm.energy(model.encode(as_it_is)) == pytest.approx(length, rel=0.1)


def test_without_repair_every_plan_is_proposed() -> None:
    loop = BatchLoop(whole_orders(10, 10, seed=1), 2, RandomSource(), repairs=False)
    loop.run(Stop(max_work=400))
    tallies = (loop.assignment, loop.neighbourhood, loop.selection)
    assert not any(tally.repaired for tally in tallies)
    assert sum(len(tally.lengths) for tally in tallies) > 0
    told = min(min(tally.lengths, default=np.inf) for tally in tallies)
    assert loop.best <= told + 1e-9


def test_the_distance_of_partitions() -> None:
    same, apart = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    assert mean_distance([same, same[::-1]]) == 0.0
    assert mean_distance([same, apart]) == 1.0
    assert mean_distance([same, np.array([0, 0, 1, 2])]) == pytest.approx(0.5)
    assert mean_distance([same]) is None


def test_there_is_a_proposal_even_when_time_is_up() -> None:
    loop = BatchLoop(whole_orders(8, 8), 0, RandomSource())
    loop.run(Stop(0.0), reads=1)
    assert loop.work == 1
    assert len(loop.plans) == 1


def test_batches_cost_nothing_to_estimate() -> None:
    assert estimate(whole_orders(14, 14), "neal") == FREE
