"""Every broken constraint is reported, with who, what, how much, and a sentence."""

from __future__ import annotations

from fractions import Fraction

import dimod
import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.errors import InputError
from qrobot.models import ENCODINGS, PickingModel, Violation, build_model
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot


def instance() -> Instance:
    """Four items in two orders, two robots of 5 kg."""
    return Instance(
        warehouse=OpenFloor(),
        items=tuple(
            Item(f"i{k}", Fraction(w, 2), Point(float(k), 1.0))
            for k, w in ((1, 2), (2, 6), (3, 4), (4, 4))
        ),
        orders=(Order("A", ("i1", "i2")), Order("B", ("i3", "i4"))),
        robots=(Robot("red", Fraction(5)), Robot("blue", Fraction(5))),
    )


def at(model: PickingModel, *where: tuple[int, int, int]) -> dict[str, int]:
    """Return the sample with these x[t,i,p] set and nothing else."""
    sample = dict.fromkeys(model.variables, 0)
    for t, i, p in where:
        sample[f"x[{t},{i},{p}]"] = 1
    return sample


def plan(model: PickingModel) -> dict[str, int]:
    return model.encode([[1, 2], [3, 4]])


def kinds(violations: tuple[Violation, ...]) -> dict[str, int]:
    found: dict[str, int] = {}
    for violation in violations:
        found[violation.kind] = found.get(violation.kind, 0) + 1
    return found


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_plan_breaks_nothing(encoding: str) -> None:
    model = build_model(instance(), encoding)
    decoded = model.decode(plan(model))
    assert decoded.violations == ()
    assert decoded.feasible
    assert decoded.routes == [[1, 2], [3, 4]]
    assert decoded.energy == pytest.approx(decoded.distance)


def test_an_empty_sample_collects_nothing_and_is_nowhere() -> None:
    model = build_model(instance(), "full")
    decoded = model.decode(at(model))
    assert kinds(decoded.violations) == {"step": 12, "depot": 4, "visit": 4}
    assert decoded.routes == [[], []]
    assert decoded.distance == float("inf")


def test_a_robot_in_two_places() -> None:
    model = build_model(instance(), "reduced")
    sample = plan(model) | {"x[1,3,1]": 1}
    found = model.decode(sample)
    assert not found.feasible
    step = next(v for v in found.violations if v.kind == "step")
    assert (step.robot, step.step, step.amount) == (0, 1, 1)
    assert step.text == "robot red is in 2 places at step 1"
    visit = next(v for v in found.violations if v.kind == "visit")
    assert (visit.item, visit.amount) == (2, 1)
    assert visit.text == "item i3 is collected 2 times"
    assert kinds(found.violations) == {"step": 1, "visit": 1, "capacity": 1, "split order": 1}


def test_an_item_left_behind() -> None:
    model = build_model(instance(), "reduced")
    sample = plan(model) | {"x[2,4,2]": 0, "x[2,0,2]": 1}
    (violation,) = model.decode(sample).violations
    assert (violation.kind, violation.item, violation.amount) == ("visit", 3, -1)
    assert violation.text == "item i4 is collected never"


def test_an_overload_and_a_split_order() -> None:
    model = build_model(instance(), "reduced")
    stay = [(t, 0, p) for t, p in ((4, 1), (2, 2), (3, 2), (4, 2))]
    decoded = model.decode(at(model, (1, 1, 1), (2, 2, 1), (3, 3, 1), (1, 4, 2), *stay))
    load, split = decoded.violations
    assert (load.kind, load.robot, load.amount) == ("capacity", 0, 1)
    assert load.text == "robot red carries 6, 1 more than the 5 it can"
    assert (split.kind, split.order, split.amount) == ("split order", 1, 1)
    assert split.text == "order B is split over 2 trips"
    assert decoded.routes == [[1, 2, 3], [4]]


def test_robots_that_do_not_start_and_end_at_the_depot() -> None:
    model = build_model(instance(), "full")
    sample = plan(model) | {"x[0,0,1]": 0, "x[0,3,1]": 1, "x[5,0,2]": 0}
    decoded = model.decode(sample)
    texts = [v.text for v in decoded.violations if v.kind == "depot"]
    assert texts == [
        "robot red does not start at the depot",
        "robot blue does not end at the depot",
    ]


@pytest.mark.parametrize("encoding", ["reduced", "full"])
def test_a_visit_of_the_depot_on_the_way_is_left_out(encoding: str) -> None:
    model = build_model(instance(), encoding)
    sample = plan(model)
    for t, node in ((1, 1), (2, 0), (3, 0), (4, 2)):
        for other in range(5):
            sample[f"x[{t},{other},1]"] = int(other == node)
    decoded = model.decode(sample)
    assert decoded.feasible
    assert decoded.routes[0] == [1, 2]
    assert decoded.distance < decoded.energy


def test_wrong_slack_is_no_violation_but_costs_energy() -> None:
    model = build_model(instance(), "reduced")
    sample = plan(model)
    sample["slack[1,0]"] = 1 - sample["slack[1,0]"]
    decoded = model.decode(sample)
    assert decoded.feasible
    assert decoded.energy == pytest.approx(decoded.distance + model.penalties.capacity)


def test_several_trips_have_names() -> None:
    one = instance()
    robots = (Robot("red", Fraction(5), trips=2),)
    model = build_model(
        Instance(one.warehouse, one.items, one.orders, robots), "reduced", penalties={"visit": 1.0}
    )
    texts = [v.text for v in model.decode(at(model)).violations]
    assert "robot red on trip 2 is nowhere at step 4" in texts


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_spins_booleans_and_reordered_columns_are_understood(encoding: str) -> None:
    model = build_model(paper_shaped(4, 1, 0), encoding)
    sample = model.encode([[2, 4, 1, 3]])
    spins = {name: 2 * value - 1 for name, value in sample.items()}
    truths = {name: bool(value) for name, value in sample.items()}
    for given in (spins, truths):
        assert model.decode(given).routes == [[2, 4, 1, 3]]
    backwards = dict(reversed(spins.items()))
    feasible, distances = model.decode_all(
        dimod.SampleSet.from_samples([backwards], energy=[0.0], vartype="SPIN")
    )
    assert feasible.all()
    assert distances[0] == pytest.approx(model.instance.length([[2, 4, 1, 3]]))


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_no_samples_give_no_verdicts(encoding: str) -> None:
    model = build_model(paper_shaped(3, 1, 0), encoding)
    none = np.zeros((0, model.num_variables), dtype=np.int8)
    samples = dimod.SampleSet.from_samples_bqm((none, model.variables), model.bqm)
    feasible, distances = model.decode_all(samples)
    assert feasible.shape == distances.shape == (0,)


def test_a_thousand_reads_are_judged_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    model = build_model(paper_shaped(5, 2, 0), "reduced")
    rng = np.random.default_rng(0)
    rows = rng.integers(0, 2, (50, model.num_variables)).astype(np.int8)
    rows[::7] = model.encode_bits([[1, 2], [3]])
    rows[3] = model.encode_bits([[1, 4], [3, 5, 2]])
    samples = dimod.SampleSet.from_samples_bqm((rows, model.variables), model.bqm)
    whole = model.decode_all(samples)
    monkeypatch.setattr("qrobot.models.samples.CELLS", 500)
    parts = model.decode_all(samples)
    assert np.array_equal(whole.feasible, parts.feasible)
    assert np.array_equal(whole.distances, parts.distances)


@pytest.mark.parametrize(
    ("routes", "message"),
    [
        ([[1], [2], [3]], "3 routes for 2 vehicles"),
        ([[0, 1]], "node 0 is not an item"),
        ([[5]], "node 5 is not an item"),
        ([[1, 2, 3, 4], [4]], "are more than robot red can take"),
        ([[1, 2], []], "no variable for robot blue at depot at step 1"),
    ],
)
def test_routes_that_the_model_cannot_hold(routes: list[list[int]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        build_model(instance(), "compact").encode(routes)


def test_the_heaviest_load_goes_to_the_largest_robot() -> None:
    one = instance()
    robots = (Robot("small", Fraction(4)), Robot("large", Fraction(6)))
    model = build_model(Instance(one.warehouse, one.items, one.orders, robots), "reduced")
    assert model.layout.fleet.names == ("large", "small")
    assert model.decode(model.encode([[3, 4], [1, 2]])).routes == [[3, 4], [1, 2]]
    heavy = [[3, 4], [1, 2, 3]]
    assert model.decode(model.encode([heavy[0][:1], heavy[1]])).routes[0] == [1, 2, 3]
