"""Trips and robots: the cheapest assignment against all of them."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.plan.objective import _cheapest

PRICES = st.one_of(st.integers(0, 9).map(float), st.floats(0, 100), st.just(float("inf")))


@given(st.data())
def test_no_assignment_is_cheaper(data: st.DataObject) -> None:
    columns = data.draw(st.integers(1, 5))
    rows = data.draw(st.integers(0, columns))
    costs = np.array(
        [[data.draw(PRICES) for _ in range(columns)] for _ in range(rows)], dtype=float
    ).reshape(rows, columns)
    least = min(
        sum((costs[i, c] for i, c in enumerate(chosen)), 0.0)
        for chosen in permutations(range(columns), rows)
    )
    if np.isinf(least):
        with pytest.raises(ValueError, match="do not fit"):
            _cheapest(costs)
        return
    found = _cheapest(costs)
    assert len(set(found)) == rows
    assert sum((costs[i, c] for i, c in enumerate(found)), 0.0) == pytest.approx(least)
