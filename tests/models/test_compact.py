"""The compact encoding: what it leaves out, and that no plan is lost."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from strategies import instances

from qrobot.errors import InfeasibleError, InputError
from qrobot.models import build_model, model_for
from qrobot.models.slack import slack_bits, slack_coefficients
from qrobot.planning.run import plan_fits
from qrobot.problem import Instance, Order, Robot


def weighing(weights: list[int], robots: list[int]) -> Instance:
    drawn = paper_shaped(len(weights), 1, 0)
    return replace(
        drawn,
        items=tuple(
            replace(i, weight=Fraction(w)) for i, w in zip(drawn.items, weights, strict=True)
        ),
        robots=tuple(Robot(f"R{k + 1}", Fraction(c)) for k, c in enumerate(robots)),
    )


@pytest.mark.parametrize("items", range(1, 13))
def test_one_robot_needs_n_times_n_variables(items: int) -> None:
    model = build_model(paper_shaped(items, 1, 0))
    assert model.num_variables == items**2
    assert not any(name.startswith("slack") or ",0," in name for name in model.variables)


def test_equal_weights_need_no_slack() -> None:
    model = build_model(weighing([2] * 7, [8, 8]))
    assert model.layout.last.tolist() == [4, 4]
    assert not model.layout.summed.any()
    # Three steps are never the depot: the other robot takes four items at most.
    assert model.num_variables == 2 * (4 * 7 + 1)


def test_pairs_need_no_slack() -> None:
    model = build_model(weighing([5, 4, 4, 3], [8, 8]))
    assert model.layout.paired.all()
    assert model.energy_of([[1, 4], [2, 3]]) == pytest.approx(
        model.instance.length([[1, 4], [2, 3]])
    )
    over = model.energy_of([[1, 2], [3, 4]])
    assert over == pytest.approx(model.instance.length([[1, 2], [3, 4]]) + model.penalties.capacity)


def test_slack_spans_only_what_the_others_leave_over() -> None:
    model = build_model(weighing([4, 3, 3, 2, 2, 2], [9, 9]))
    assert model.layout.summed.all()
    assert model.layout.slack_coefficient.tolist() == [1, 1, 1, 1]  # loads of 7 to 9


def test_items_that_are_too_heavy_for_a_robot_have_no_variables_there() -> None:
    model = build_model(weighing([5, 2, 2], [6, 4]))
    assert "x[1,1,1]" in model.variables
    assert not any(name.startswith("x[1,1,2]") for name in model.variables)


@pytest.mark.parametrize(
    ("weights", "robots", "reason"),
    [
        ([9, 9], [8, 8], "no robot holds more than 8"),
        ([5, 4, 6], [7, 7], "total load 15 exceeds 14, the most that 2 trips hold"),
        ([5, 5, 4], [8, 8], "2 trips carry at most 2 of the 3 items: no robot holds more"),
        ([1, 1, 9], [9], "total load 11 exceeds 9"),
        ([8, 8, 3], [2, 6, 12], "at least 1 items are left for robot R1, whose 2 holds 0"),
    ],
)
def test_what_cannot_fit_is_refused_with_the_reason(
    weights: list[int], robots: list[int], reason: str
) -> None:
    with pytest.raises(InfeasibleError, match=reason) as refusal:
        build_model(weighing(weights, robots))
    assert refusal.value.proven
    assert build_model(weighing(weights, robots), "reduced").num_variables > 0


@settings(max_examples=100)
@given(instance=instances(max_items=6, multi_trip=True))
def test_no_instance_with_a_plan_is_refused(instance: Instance) -> None:
    try:
        build_model(instance)
    except InfeasibleError:
        assert least_distance(instance) is None


@settings(max_examples=80)
@given(instance=instances(min_items=1, max_items=5, multi_trip=True), data=st.data())
def test_any_plan_can_be_encoded_with_and_without_symmetry(
    instance: Instance, data: st.DataObject
) -> None:
    routes: list[list[int]] = [[] for _ in instance.vehicle_capacities]
    for nodes in instance.order_nodes:
        routes[data.draw(st.integers(0, len(routes) - 1))] += nodes
    assume(plan_fits(instance, [route for route in routes if route]))
    for symmetry in ("keep", "break"):
        model = build_model(instance, symmetry=symmetry)
        decoded = model.decode(model.encode(routes))
        assert decoded.feasible, decoded.violations
        assert sorted(map(tuple, decoded.routes)) == sorted(map(tuple, routes))
        assert decoded.energy == pytest.approx(instance.length(routes), abs=1e-6)


def test_breaking_the_symmetry_saves_variables() -> None:
    instance = paper_shaped(9, 3, 1)
    kept = build_model(instance)
    broken = build_model(instance, symmetry="break")
    steps = int(kept.layout.last[0])
    assert kept.num_variables - broken.num_variables == 3 * steps
    with pytest.raises(InputError, match="keeps its symmetry"):
        build_model(instance, "reduced", symmetry="break")


def test_nothing_to_collect_is_an_empty_model() -> None:
    instance = replace(paper_shaped(1, 1, 0), items=(), orders=())
    for encoding in ("compact", "reduced", "full"):
        model = build_model(instance, encoding)
        assert model.energy_of([]) == pytest.approx(0.0)
        assert model.decode(model.encode([])).routes == [[]]
    assert build_model(instance).num_variables == 0


def test_items_without_weight_and_robots_below_the_unit() -> None:
    model = build_model(weighing([0, 0, 0], [1, 1]))
    assert model.decode(model.encode([[1, 2, 3]])).feasible
    tiny = replace(
        weighing([0, 0, 4], [4, 1]), robots=(Robot("R1", Fraction(4)), Robot("R2", Fraction(1, 3)))
    )
    model = build_model(tiny)
    assert model.decode(model.encode([[3], [1, 2]])).feasible


@pytest.mark.parametrize("encoding", ["compact", "reduced", "full"])
def test_too_large_models_are_refused_before_they_are_built(encoding: str) -> None:
    many = paper_shaped(400, 3, 0)
    with pytest.raises(InputError, match=r"binary variables, more than the 5000"):
        build_model(many, encoding)


@pytest.mark.parametrize("option", [{"encoding": "tiny"}, {"slack": "none"}, {"symmetry": "yes"}])
def test_unknown_options_are_refused(option: dict[str, str]) -> None:
    with pytest.raises(InputError, match="is unknown; use"):
        build_model(paper_shaped(2, 1, 0), **option)


def test_purposes_have_their_models() -> None:
    instance = paper_shaped(4, 2, 0)
    assert model_for(instance).encoding == "compact"
    assert model_for(instance, "gate").encoding == "compact"
    paper = model_for(instance, "paper")
    assert (paper.encoding, paper.slack) == ("reduced", "paper")
    with pytest.raises(InputError, match="use anneal, gate, paper"):
        model_for(instance, "cook")


@given(room=st.integers(0, 5000), value=st.integers(-10, 6000))
def test_exact_slack_reaches_every_value_and_nothing_above(room: int, value: int) -> None:
    coefficients = slack_coefficients(room)
    assert int(coefficients.sum()) == room
    assert len(coefficients) == room.bit_length()
    assert all(a <= b for a, b in pairwise(coefficients[:-1]))
    reached = int(slack_bits(value, coefficients) @ coefficients)
    assert reached == min(max(value, 0), room)


@given(room=st.integers(1, 5000))
def test_the_papers_slack_has_its_number_of_bits(room: int) -> None:
    coefficients = slack_coefficients(room, "paper")
    assert 2 ** len(coefficients) >= room
    assert len(coefficients) == 0 or 2 ** (len(coefficients) - 1) < room


def test_orders_of_several_items_stay_together_in_the_limits() -> None:
    instance = weighing([3, 3, 2, 2], [6, 6])
    whole = replace(
        instance, orders=(Order("A", ("i1", "i2")), Order("B", ("i3",)), Order("C", ("i4",)))
    )
    assert build_model(whole).layout.last.tolist() == [2, 2]
    assert build_model(instance).layout.last.tolist() == [2, 2]
    uneven = replace(instance, orders=(Order("A", ("i1", "i3")), Order("B", ("i2", "i4"))))
    assert build_model(uneven).layout.last.tolist() == [2, 2]


@pytest.mark.parametrize("encoding", ["reduced", "full"])
def test_a_capacity_that_swallows_all_digits_is_refused(encoding: str) -> None:
    roomy = weighing([1, 2, 3], [10_000])
    model = build_model(roomy, encoding)
    assert model.energy_of([[1, 2, 3]]) == pytest.approx(roomy.length([[1, 2, 3]]), rel=1e-7)
    boundless = weighing([1, 2, 3], [10**9])
    with pytest.raises(InputError, match="a capacity no larger than the total load 6"):
        build_model(boundless, encoding)
    assert build_model(boundless).num_variables == 9
