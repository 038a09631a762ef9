"""What leaves the house as a model has the best plan as its lowest energy."""

from __future__ import annotations

import io
import itertools
import json
from fractions import Fraction
from pathlib import Path

import dimod
import numpy as np
import pytest
from dimod.serialization import coo
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import least_distance
from strategies import warehouses_with_places

from qrobot.errors import InfeasibleError, InputError
from qrobot.models import build_model
from qrobot.models.export import export_model
from qrobot.problem import Instance, Item, Order, Robot

MOST = 20
"""Variables: all assignments are looked at."""


@st.composite
def tiny_instances(draw: st.DrawFn) -> Instance:
    """Draw up to three items and two robots, perhaps unlike, with whole orders and zero weights."""
    count, robots = draw(st.sampled_from([(1, 1), (1, 2), (2, 1), (2, 2), (3, 1)]))
    warehouse, places = draw(warehouses_with_places(count=count))
    unit = draw(st.sampled_from([Fraction(1), Fraction(7, 20)]))
    items = tuple(
        Item(f"i{k}", draw(st.integers(0, 2)) * unit, place) for k, place in enumerate(places)
    )
    together = draw(st.booleans())
    orders = (
        (Order("all", tuple(item.id for item in items)),)
        if together
        else tuple(Order(item.id, (item.id,)) for item in items)
    )
    fleet = tuple(Robot(f"R{k}", draw(st.integers(1, 4)) * unit) for k in range(robots))
    return Instance(warehouse=warehouse, items=items, orders=orders, robots=fleet, name="tiny")


def lowest(bqm: dimod.BinaryQuadraticModel) -> float:
    bits = np.array(list(itertools.product((0, 1), repeat=bqm.num_variables)), dtype=np.int8)
    return float(bqm.energies((bits, list(bqm.variables))).min())


def written(
    instance: Instance, folder: Path, ending: str, encoding: str
) -> tuple[dimod.BinaryQuadraticModel, dict[str, object]]:
    """Write a model and read it back with dimod."""
    path = folder / f"model{ending}"
    report = export_model(instance, path, encoding)
    if ending == ".bqm":
        return dimod.BinaryQuadraticModel.from_file(io.BytesIO(path.read_bytes())), report
    if ending == ".coo":
        bqm = coo.loads(path.read_text())
        bqm.offset += report["offset"]  # as the report says: the format has no place for it
        return bqm, report
    return dimod.BinaryQuadraticModel.from_serializable(json.loads(path.read_text())), report


@pytest.mark.parametrize("encoding", ["compact", "reduced", "full"])
@settings(max_examples=30)
@given(instance=tiny_instances())
def test_the_lowest_energy_of_a_written_model_is_the_best_plan(
    encoding: str, instance: Instance, tmp_path_factory: pytest.TempPathFactory
) -> None:
    try:
        size = build_model(instance, encoding).num_variables
    except (InfeasibleError, InputError):
        assume(False)
    assume(0 < size <= MOST)
    best = least_distance(instance)
    assume(best is not None)
    folder = tmp_path_factory.mktemp("written")
    for ending in (".bqm.json", ".bqm", ".coo"):
        bqm, report = written(instance, folder, ending, encoding)
        assert report["ground_state_is_plan"]
        assert lowest(bqm) == pytest.approx(best[0], abs=1e-6)


def test_measured_weights_are_not_called_safe(tmp_path: Path) -> None:
    """Two items of weight 1 at one place, two robots of capacity 1: staying home is cheaper."""
    text = {
        "schema": "qrobot.instance/1",
        "warehouse": {"kind": "floor", "depot": {"x": 0, "y": 0}},
        "items": [{"id": c, "weight": 1, "at": {"x": 3, "y": 0}} for c in "ab"],
        "robots": {"count": 2, "capacity": 1},
    }
    path = tmp_path / "two.json"
    path.write_text(json.dumps(text))
    from qrobot.problem.formats import read

    instance = read(path)
    report = export_model(instance, tmp_path / "m.bqm.json", "reduced", penalties="measured")
    assert not report["ground_state_is_plan"]
    bqm = dimod.BinaryQuadraticModel.from_serializable(
        json.loads((tmp_path / "m.bqm.json").read_text())
    )
    assert lowest(bqm) < 12.0 - 1e-6
    report = export_model(instance, tmp_path / "m.bqm.json", "reduced", "paper")
    assert not report["ground_state_is_plan"]  # the paper's slack need not reach the capacity
    bqm, _ = written(instance, tmp_path, ".bqm.json", "reduced")
    assert lowest(bqm) == pytest.approx(12.0)
