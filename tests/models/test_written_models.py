"""What leaves the house as a model has the best plan as its lowest energy."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import dimod
import numpy as np
import pytest
from dimod.serialization import coo
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from oracles import assignments, least_distance
from strategies import instances, warehouses_with_places

from qrobot.errors import InfeasibleError, InputError
from qrobot.models import build_model
from qrobot.models.export import export_model
from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Robot

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
    bits = assignments(bqm.num_variables)
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


def coarse(instance: Instance, grain: Fraction) -> Instance:
    """Return an instance with few units of weight, zero among them: a slack of few binaries."""
    items = tuple(
        replace(item, weight=Fraction(round(item.weight / 3)) * grain) for item in instance.items
    )
    return replace(instance, items=items)


@pytest.mark.parametrize("slack", ["exact", "paper"])
@pytest.mark.parametrize("encoding", ["compact", "reduced", "full"])
@settings(max_examples=30, suppress_health_check=[HealthCheck.filter_too_much])
@given(
    instance=instances(min_items=1, max_items=4, max_robots=3, multi_trip=True),
    grain=st.sampled_from([Fraction(1), Fraction(1, 2), Fraction(3, 10)]),
)
def test_what_is_said_of_the_lowest_energy_is_true(
    encoding: str,
    slack: str,
    instance: Instance,
    grain: Fraction,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    instance = coarse(instance, grain)
    best = least_distance(instance)
    assume(best is not None)
    assert best is not None
    model = build_model(instance, encoding, slack, penalties="safe")
    assume(0 < model.num_variables <= MOST - 2)
    path = tmp_path_factory.mktemp("written") / "model.bqm.json"
    report = export_model(instance, path, encoding, slack)
    bqm = dimod.BinaryQuadraticModel.from_serializable(json.loads(path.read_text()))
    if slack == "exact":
        assert report["ground_state_is_plan"]
    if not report["ground_state_is_plan"]:
        return
    bits = assignments(bqm.num_variables)
    energies = bqm.energies((bits, model.variables))
    decoded = model.decode(
        dict(zip(model.variables, bits[int(energies.argmin())].tolist(), strict=True))
    )
    assert float(energies.min()) == pytest.approx(best[0], abs=1e-6)
    assert decoded.feasible, decoded.violations
    assert decoded.distance == pytest.approx(best[0], abs=1e-6)


@pytest.mark.parametrize("slack", [None, "exact", "paper"])
@pytest.mark.parametrize("encoding", ["reduced", "full"])
@settings(max_examples=30)
@given(instance=instances(min_items=1, max_items=3, max_robots=3, multi_trip=True))
def test_what_is_said_of_the_best_of_an_lp_is_true(
    encoding: str, slack: str | None, instance: Instance, tmp_path_factory: pytest.TempPathFactory
) -> None:
    pytest.importorskip("docplex", reason="docplex is not installed")
    instance = coarse(instance, Fraction(1))
    best = least_distance(instance)
    assume(best is not None)
    assert best is not None
    path = tmp_path_factory.mktemp("written") / "model.lp"
    report = export_model(instance, path, encoding, slack)
    assume(report["variables"] <= 16)
    if slack != "paper":
        assert report["ground_state_is_plan"]
    if report["ground_state_is_plan"]:
        assert best_of_lp(path) == pytest.approx(best[0], abs=1e-6)


def best_of_lp(path: Path) -> float:
    """Return the least value of an LP as dimod reads it, all assignments looked at."""
    cqm = dimod.lp.load(str(path))
    names = list(cqm.variables)
    bits = assignments(len(names))
    kept = np.ones(len(bits), dtype=bool)
    for constraint in cqm.constraints.values():
        left, right = constraint.lhs.energies((bits, names)), constraint.rhs
        equal = constraint.sense is dimod.sym.Sense.Eq
        kept &= np.isclose(left, right) if equal else left <= right + 1e-9
    return float(cqm.objective.energies((bits[kept], names)).min(initial=np.inf))


def table(weights: list[Fraction], capacity: Fraction, robots: int = 2) -> Instance:
    ways = ((0.0, 9.0, 8.0, 7.0), (9.0, 0.0, 3.0, 4.0), (8.0, 3.0, 0.0, 5.0), (7.0, 4.0, 5.0, 0.0))
    n = len(weights)
    return Instance(
        warehouse=DistanceTable(matrix=tuple(row[: n + 1] for row in ways[: n + 1])),
        items=tuple(Item(f"i{k + 1}", w, Node(k + 1)) for k, w in enumerate(weights)),
        orders=tuple(Order(f"i{k + 1}", (f"i{k + 1}",)) for k in range(n)),
        robots=tuple(Robot(f"R{k}", capacity) for k in range(robots)),
    )


@pytest.mark.parametrize("encoding", ["reduced", "full"])
def test_a_slack_of_the_paper_that_is_too_short_is_told(encoding: str, tmp_path: Path) -> None:
    """Both items on one robot are best, and the other robot, empty, wants a slack of M."""
    pytest.importorskip("docplex", reason="docplex is not installed")
    instance = table([Fraction(1), Fraction(1)], Fraction(4))
    for name in ("model.lp", "model.bqm.json"):
        report = export_model(instance, tmp_path / name, encoding, "paper")
        assert not report["ground_state_is_plan"]
    if encoding == "reduced":
        assert best_of_lp(tmp_path / "model.lp") > 20.0  # so it has to be told


@pytest.mark.parametrize("encoding", ["compact", "reduced", "full"])
def test_weights_in_grams_keep_the_digits_of_distances(encoding: str, tmp_path: Path) -> None:
    """50 kg in grams are 50,000 units; the least overload is 8,600 of them, far more than one."""
    grams = [Fraction(w, 1000) for w in (31_417, 27_183, 14_142)]
    instance = table(grams, Fraction(50))
    report = export_model(instance, tmp_path / "model.bqm.json", encoding)
    assert report["ground_state_is_plan"]
    weights = report["penalties"]
    assert weights["capacity"] * 8_600**2 == pytest.approx(weights["visit"])
    model = build_model(instance, encoding, penalties="safe")
    best = least_distance(instance)
    assert best is not None
    # The third item fits beside either of the others, which do not fit together.
    energies = [model.energy_of(plan) for plan in ([[1], [2, 3]], [[2], [1, 3]])]
    assert min(energies) == pytest.approx(best[0], abs=1e-6)
