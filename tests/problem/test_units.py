"""Weights are exact: nothing is ever rounded in favour of a plan."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.errors import InputError
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot
from qrobot.problem.units import MAX_UNITS, MAX_WEIGHT, common_unit, exact, in_units

decimals = st.decimals(0, 1000, places=4, allow_nan=False, allow_infinity=False)


def instance(weights: list[Fraction], capacity: Fraction) -> Instance:
    items = tuple(Item(f"i{n}", w, Point(n, 0)) for n, w in enumerate(weights))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    return Instance(OpenFloor(), items, orders, (Robot("R1", capacity),))


@pytest.mark.parametrize(
    ("value", "fraction"),
    [
        (0.1, Fraction(1, 10)),
        ("0.1", Fraction(1, 10)),
        (Decimal("0.10"), Fraction(1, 10)),
        (3, Fraction(3)),
        (1e-7, Fraction(1, 10**7)),
        ("2.5e3", Fraction(2500)),
        (Fraction(1, 3), Fraction(1, 3)),
        (np.float64(0.3), Fraction(3, 10)),
        (np.int64(7), Fraction(7)),
    ],
)
def test_a_number_is_what_its_notation_says(value: float, fraction: Fraction) -> None:
    assert exact(value, field="w") == fraction


@pytest.mark.parametrize(
    "value",
    [
        *(
            "nan",
            "inf",
            float("nan"),
            float("-inf"),
            Decimal("sNaN"),
            "",
            "1/3",
            "1,5",
            "abc",
            True,
        ),
        *("1e400", Decimal("1e400"), "-1e999999999", "1e999999999999999999999"),
        *("1e-999999999", "0." + "3" * 61, [], None, pytest.param(10**5000, id="5000 digits")),
    ],
)
def test_what_is_no_weight(value: object) -> None:
    with pytest.raises(InputError, match=r"^w: .*; ") as caught:
        exact(value, field="w")  # type: ignore[arg-type]
    assert len(str(caught.value)) < 200


@given(decimals)
def test_every_notation_of_a_decimal_is_the_same_number(value: Decimal) -> None:
    assert exact(value, field="") == exact(str(value), field="") == Fraction(value)
    assert exact(float(value), field="") == Fraction(value)


@given(
    st.lists(
        st.builds(Fraction, st.integers(0, 900), st.sampled_from([1, 3, 7, 8, 60])), max_size=8
    )
)
def test_weights_are_whole_multiples_of_the_largest_unit(weights: list[Fraction]) -> None:
    unit = common_unit(weights, field="items")
    whole = in_units(weights, unit)
    assert [int(n) * unit for n in whole] == weights
    assert not any(weights) or np.gcd.reduce(whole) == 1


@given(st.lists(decimals, min_size=1, max_size=6), st.decimals("0.0001", 2000, places=4))
def test_a_load_fits_in_units_exactly_when_it_fits(weights: list[Decimal], room: Decimal) -> None:
    one = instance([Fraction(w) for w in weights], Fraction(room))
    for count in range(1, len(weights) + 1):
        truly = sum(map(Fraction, weights[:count])) <= Fraction(room)
        assert (int(one.weights[:count].sum()) <= int(one.capacities[0])) == truly


@given(st.fractions("0.01", 100), st.fractions("0.01", 100))
def test_capacity_is_never_rounded_up(weight: Fraction, capacity: Fraction) -> None:
    one = instance([weight], capacity)
    assert int(one.capacities[0]) * one.unit <= capacity


def test_zero_weights_alone_have_a_unit() -> None:
    assert instance([Fraction(0)], Fraction(1)).weights.tolist() == [0]
    assert common_unit([], field="items") == 1


def test_too_many_digits_are_refused_with_the_advice() -> None:
    with pytest.raises(
        InputError, match=r"items\[1\].weight: .*no common unit.*; round the weights up"
    ):
        _ = instance([Fraction(1), Fraction(1, 10**15)], Fraction(2)).weights


def test_capacities_beyond_all_loads_stay_representable() -> None:
    one = instance([Fraction(1, 1000)], Fraction(MAX_WEIGHT))
    assert one.capacities.tolist() == [min(MAX_WEIGHT * 1000, MAX_UNITS)]


def test_plain_numbers_are_taken_for_their_decimals() -> None:
    assert Item("a", 0.1, Point(0, 0)).weight == Fraction(1, 10)  # type: ignore[arg-type]
    assert Robot("R1", 2.5).capacity == Fraction(5, 2)  # type: ignore[arg-type]


def test_a_decimal_comma_is_told_how_to_write_it() -> None:
    with pytest.raises(InputError, match=r"15,5 is not a finite number; write 15\.5: a point"):
        exact("15,5", field="capacity")
