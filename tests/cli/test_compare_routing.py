"""``qrobot compare-routing``: the table, JSON, pictures, and what is refused."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from pathlib import Path

import pytest
from cli.test_commands import EXAMPLES, one_sentence, qrobot

import qrobot as package
from qrobot.problem import AisleWarehouse, Slot
from qrobot.report import compare_routing
from qrobot.warehouse import POLICIES

TWO_BLOCKS = EXAMPLES / "small-warehouse.json"


def plan_of(instance: package.Instance) -> package.Plan:
    """Return whole orders on robots as they fit, in no good sequence."""
    node = {item.id: k for k, item in enumerate(instance.items, 1)}
    loads = [Fraction(0)] * len(instance.robots)
    routes: list[list[int]] = [[] for _ in loads]
    for order in instance.orders:
        nodes = [node[item] for item in order.items]
        weight = sum((instance.items[k - 1].weight for k in nodes), Fraction(0))
        robot = loads.index(min(loads))
        loads[robot] += weight
        routes[robot] += nodes
    return package.Plan.from_routes(instance, routes)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plan") / "plan.json"
    path.write_text(json.dumps(plan_of(package.read(TWO_BLOCKS)).to_dict()))
    return path


def test_policies_stand_beside_the_shortest(plan: Path) -> None:
    done = qrobot("compare-routing", plan, TWO_BLOCKS)
    assert (done.returncode, done.stderr) == (0, "")
    rows = done.stdout.splitlines()
    named = [row.split()[0] for row in rows[3:9]]
    assert named == [p for p in POLICIES if p not in {"return", "midpoint"}]
    assert rows[9:] == [
        f"'{policy}' is a policy for one block, the warehouse has 2; use shortest or as-given"
        for policy in ("return", "midpoint")
    ]


def test_json_has_every_trip_in_the_sequence_of_the_policy(plan: Path) -> None:
    data = json.loads(qrobot("compare-routing", plan, TWO_BLOCKS, "--json").stdout)
    trips = json.loads(plan.read_text())["trips"]
    instance = package.read(TWO_BLOCKS)
    node = {item.id: k for k, item in enumerate(instance.items, 1)}
    assert data["schema"] == "qrobot.compare-routing/1"
    shortest = data["policies"][0]["distance"]
    assert shortest <= data["plan_distance"] + 1e-9
    for row in data["policies"]:
        if row["problem"]:
            assert (row["distance"], row["trips"]) == (None, [])
            continue
        assert row["distance"] >= shortest - 1e-9
        assert row["against_shortest"] == pytest.approx(row["distance"] / shortest - 1)
        assert sum(trip["distance"] for trip in row["trips"]) == pytest.approx(row["distance"])
        for trip, given in zip(row["trips"], trips, strict=True):
            assert sorted(trip["stops"]) == sorted(given["stops"])
            direct = instance.route_length([node[stop] for stop in trip["stops"]])
            assert direct <= trip["distance"] + 1e-9


def test_pictures_have_a_panel_for_each_policy(plan: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    paths = [tmp_path / name for name in ("a.svg", "a.png", "a.html")]
    words = [word for path in paths for word in ("--picture", path)]
    done = qrobot("compare-routing", plan, TWO_BLOCKS, *words)
    assert done.returncode == 0
    assert [f"written: {path}" for path in paths] == done.stdout.splitlines()[-3:]
    named = [p for p in POLICIES if p not in {"return", "midpoint"}]
    for path in (paths[0], paths[2]):
        titles = re.findall(rf">\s*({'|'.join(named)}): [\d.,]+ m", path.read_text())
        assert list(dict.fromkeys(titles)) == named
    assert len(re.findall("<svg", paths[2].read_text())) == len(named)
    assert paths[1].read_bytes().startswith(b"\x89PNG")


def test_as_given_follows_a_sort_index() -> None:
    instance = package.read(TWO_BLOCKS)
    plan = plan_of(instance)
    slots = {item.place: k for k, item in enumerate(instance.items)}
    index = {place: -float(k) for place, k in slots.items() if isinstance(place, Slot)}
    assert isinstance(instance.warehouse, AisleWarehouse)
    (ways,) = [w for w in compare_routing(plan, instance, index).ways if w.policy == "as-given"]
    assert ways.scene is not None
    for journey in ways.scene.journeys:
        ranks = [index[item.place] for item in journey.items if isinstance(item.place, Slot)]
        assert ranks == sorted(ranks)
        direct = package.Plan.from_routes(
            instance, [[slots[item.place] + 1 for item in journey.items]]
        )
        assert journey.trip.distance == pytest.approx(direct.distance)


def test_what_cannot_be_compared_is_refused(plan: Path, tmp_path: Path) -> None:
    wrong = json.loads(plan.read_text())
    wrong["trips"][0]["distance"] += 1
    (tmp_path / "wrong.json").write_text(json.dumps(wrong))
    done = qrobot("compare-routing", tmp_path / "wrong.json", TWO_BLOCKS)
    assert done.returncode == 2
    assert "is not right for this instance" in one_sentence(done)
    done = qrobot("compare-routing", plan, TWO_BLOCKS, "--picture", tmp_path / "a.pdf")
    assert done.returncode == 2
    assert "does not say the kind of picture" in one_sentence(done)
    floor = EXAMPLES / "tiny.vrp"
    (tmp_path / "p.json").write_text(json.dumps(plan_of(package.read(floor)).to_dict()))
    done = qrobot("compare-routing", tmp_path / "p.json", floor)
    assert done.returncode == 2
    assert "rules for aisles" in one_sentence(done)
