"""Batches of orders as binary quadratic models: least energies by brute force, reads judged."""

from itertools import combinations, product

import dimod
import numpy as np
import pytest

from qrobot.models.batches import Assignment, Selection

CASES = range(12)


def drawn(seed: int) -> tuple[np.random.Generator, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return weights, capacities of two trips, lengths alone, and savings, some negative."""
    rng = np.random.default_rng(seed)
    weights = rng.integers(1, 6, int(rng.integers(2, 6)))
    rooms = np.array([max(weights.max(), -(-int(weights.sum()) // 2) + k) for k in (2, 1)])
    alone = rng.integers(10, 50, len(weights)).astype(float)
    savings = np.triu(rng.uniform(-4.0, 20.0, (len(weights), len(weights))), 1)
    return rng, weights, rooms, alone, savings + savings.T


def surrogate(trips: tuple[int, ...], alone: np.ndarray, savings: np.ndarray) -> float:
    pairs = combinations(range(len(trips)), 2)
    return float(alone.sum()) - sum(savings[i, j] for i, j in pairs if trips[i] == trips[j])


def plans(weights: np.ndarray, rooms: np.ndarray) -> list[tuple[int, ...]]:
    """Return all ways to put orders on trips that fit."""
    return [
        trips
        for trips in product(range(len(rooms)), repeat=len(weights))
        if all(
            sum(w for w, t in zip(weights, trips, strict=True) if t == k) <= room
            for k, room in enumerate(rooms)
        )
    ]


@pytest.mark.parametrize("seed", CASES)
def test_the_least_energy_of_an_assignment_is_the_best_plan(seed: int) -> None:
    _, weights, rooms, alone, savings = drawn(seed)
    allowed = plans(weights, rooms)
    assert allowed, "drawn so that a plan exists"
    best = min(surrogate(trips, alone, savings) for trips in allowed)
    model = Assignment(weights, rooms, alone, savings)
    states = dimod.ExactSolver().sample(model.bqm)
    assert states.first.energy == pytest.approx(best)
    ground = model.decode_all(states.lowest(atol=1e-6))
    assert ground.feasible.all()
    for trips in ground.trips:
        assert surrogate(tuple(trips), alone, savings) == pytest.approx(best)


@pytest.mark.parametrize("seed", CASES)
def test_every_plan_has_its_surrogate_as_energy(seed: int) -> None:
    _, weights, rooms, alone, savings = drawn(seed)
    model = Assignment(weights, rooms, alone, savings, *Assignment.measured(weights, savings, 9))
    for trips in plans(weights, rooms):
        sample = model.encode(np.array(trips))
        assert model.bqm.energy(sample) == pytest.approx(surrogate(trips, alone, savings))
        read = model.decode_all(dimod.SampleSet.from_samples_bqm([sample], model.bqm))
        assert read.feasible.all()
        assert tuple(read.trips[0]) == trips


def test_every_state_of_an_assignment_is_judged() -> None:
    _, weights, rooms, alone, savings = drawn(2)
    model = Assignment(weights, rooms, alone, savings)
    states = dimod.ExactSolver().sample(model.bqm)
    reads = model.decode_all(states)
    assert len(reads.trips) == len(states)
    for row, missing, repeated, overload, trips in zip(
        states.samples(sorted_by=None), *_parts(reads), strict=True
    ):
        on = [[t for t in range(2) if row.get(f"x[{o},{t + 1}]", 0)] for o in range(len(weights))]
        loads = [
            sum(int(w) for w, own in zip(weights, on, strict=True) if t in own) for t in (0, 1)
        ]
        assert missing == sum(not own for own in on)
        assert repeated == sum(len(own) > 1 for own in on)
        assert overload == sum(max(0, load - int(c)) for load, c in zip(loads, rooms, strict=True))
        assert [own[0] if own else -1 for own in on] == trips.tolist()


def _parts(reads):
    return reads.missing, reads.repeated, reads.overload, reads.trips


def test_an_order_has_no_variable_on_a_trip_that_it_overloads() -> None:
    model = Assignment(np.array([5, 2]), np.array([6, 3]), np.array([8.0, 9.0]), np.zeros((2, 2)))
    assert "x[0,2]" not in model.labels
    assert dimod.ExactSolver().sample(model.bqm).first.energy == pytest.approx(17.0)


@pytest.mark.parametrize("seed", CASES)
def test_the_least_energy_of_a_selection_is_the_best_plan(seed: int) -> None:
    rng, weights, _, _, _ = drawn(seed)
    orders = range(len(weights))
    every = [b for size in (1, 2, 3) for b in combinations(orders, size)]
    singles = [(o,) for o in orders]
    picked = [every[k] for k in rng.permutation(len(every))[:8]]
    batches = list(dict.fromkeys(singles + picked))
    lengths = rng.integers(5, 60, len(batches)).astype(float)
    best = min(
        sum(lengths[k] for k in chosen)
        for size in range(1, len(weights) + 1)
        for chosen in combinations(range(len(batches)), size)
        if sorted(o for k in chosen for o in batches[k]) == list(orders)
    )
    rooms = np.full(len(weights), int(weights.sum()))
    model = Selection(batches, lengths, weights, rooms)
    states = dimod.ExactSolver().sample(model.bqm)
    assert states.first.energy == pytest.approx(best)
    assert model.decode_all(states.lowest(atol=1e-6)).feasible.all()
    for chosen in ([0], [0, 1], list(orders)):
        sample = model.encode(chosen)
        times = np.bincount([o for k in chosen for o in batches[k]], minlength=len(weights))
        energy = lengths[chosen].sum() + model.cover * ((1 - times) ** 2).sum()
        assert model.bqm.energy(sample) == pytest.approx(energy)


def test_a_selection_tells_what_is_missing_repeated_and_too_heavy() -> None:
    batches = [(0, 1), (1, 2), (2,), (3,)]
    model = Selection(batches, np.ones(4), np.array([2, 2, 2, 2]), np.array([3, 4]))
    chosen = [[0, 1], [0, 2], [0, 2, 3], [1, 0, 3]]
    samples = dimod.SampleSet.from_samples_bqm([model.encode(c) for c in chosen], model.bqm)
    reads = model.decode_all(samples)
    assert reads.missing.tolist() == [1, 1, 0, 0]
    assert reads.repeated.tolist() == [1, 0, 0, 1]
    # Loads 4 and 4 on robots of 4 and 3; 4 and 2; 4, 2 and 2 on two; 4, 4 and 2 on two.
    assert reads.overload.tolist() == [1, 0, 2, 3]
    assert not reads.feasible.any()
    assert reads.trips[1].tolist() == [0, 0, 1, -1]


def test_random_proposals_are_judged_as_reads_are() -> None:
    rng, weights, rooms, alone, savings = drawn(5)
    model = Assignment(weights, rooms, alone, savings)
    dealt = model.draw(50, rng)
    fitting = set(plans(weights, rooms))
    assert [tuple(t) in fitting for t in dealt.trips.tolist()] == dealt.feasible.tolist()
    chosen = Selection([(0,), (0, 1), (1,)], np.ones(3), np.array([1, 1]), np.array([2, 2]))
    drawn_reads = chosen.draw(20, rng)
    assert drawn_reads.feasible.all()  # what is left over of two orders always fits
    assert len({tuple(t) for t in drawn_reads.trips.tolist()}) > 1
