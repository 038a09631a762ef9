"""Energies of every encoding on any assignment, against loops over the formulas."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from fractions import Fraction

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

from qrobot.errors import InfeasibleError
from qrobot.models import ENCODINGS, Penalties, PickingModel, build_model
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

# -- the formulas of docs/formulation.md as loops; nothing of qrobot.models is used ----------


def slack_values(room: int, kind: str) -> list[int]:
    """Coefficients of the slack."""
    if room <= 0:
        return []
    if kind == "paper":
        return [2**b for b in range(math.ceil(math.log2(room)))]
    count = int(math.log2(room)) + 1
    return [2**b for b in range(count - 1)] + [room - (2 ** (count - 1) - 1)]


class Vehicles:
    """Rooms of the vehicles and what every feasible plan keeps to, by trying all subsets."""

    def __init__(self, instance: Instance, encoding: str) -> None:
        orders = len(instance.orders)
        seats = []
        for robot in instance.robots:
            room = math.floor(robot.capacity / instance.unit)
            seats += [room] * min(robot.trips, max(orders, 1))
        seats.sort(reverse=True)
        self.rooms = seats if encoding != "compact" else seats[: max(orders, 1)]
        lots = [instance.order_nodes[o] for o in range(orders)]
        weight = [int(w) for w in instance.weights]
        total = sum(weight)
        self.most, self.least, self.low, self.mode = [], [], [], []
        for room in self.rooms:
            counts = [0]
            for size in range(1, orders + 1):
                for chosen in itertools.combinations(lots, size):
                    nodes = [v for lot in chosen for v in lot]
                    if sum(weight[v - 1] for v in nodes) <= room:
                        counts.append(len(nodes))
            self.most.append(max(counts))
        for k, room in enumerate(self.rooms):
            self.low.append(max(0, total - (sum(self.rooms) - room)))
            heaviest = sorted(weight, reverse=True)
            reach = next(
                (c for c in range(len(weight) + 1) if sum(heaviest[:c]) >= self.low[k]),
                len(weight) + 1,
            )
            others = sum(self.most) - self.most[k]
            self.least.append(max(reach, instance.size - others, 0))
            binding = sum(heaviest[: self.most[k]]) > room
            self.mode.append("none" if not binding else "pairs" if self.most[k] <= 2 else "sum")


def potentials(instance: Instance, several: bool) -> tuple[list[float], list[float]]:
    d = instance.distances.tolist()
    n = instance.size

    def half(node: int, way: list[list[float]], among: list[int], count: int) -> float:
        near = sorted(way[node][j] for j in among if j != node)[:count]
        return sum(near) / len(near) / 2 if near else 0.0

    back = [list(column) for column in zip(*d, strict=True)]
    if n == 0:
        return [0.0], [0.0]
    if not several:
        nodes = list(range(n + 1))
        return (
            [half(i, d, nodes, 3) for i in nodes],
            [half(i, back, nodes, 3) for i in nodes],
        )
    items = list(range(1, n + 1))
    near = min(2, n - 1)
    u = [0.0] + [(near * half(i, d, items, 2) + d[i][0] / 2) / (near + 1) for i in items]
    v = [0.0] + [(near * half(i, back, items, 2) + d[0][i] / 2) / (near + 1) for i in items]
    u[0] = 0.25 * sum(d[0][j] - v[j] for j in items) / n
    v[0] = 0.25 * sum(d[i][0] - u[i] for i in items) / n
    return u, v


def energy(
    instance: Instance, encoding: str, kind: str, weight: Penalties, sample: dict[str, int]
) -> float:
    """The energy of a sample of a model, summed term by term."""
    step, visit = weight.step, weight.visit
    capacity, same = weight.capacity, weight.same_robot
    detour, shift = weight.detour, weight.shift
    n = instance.size
    d = instance.distances.tolist()
    w = [0, *(int(x) for x in instance.weights)]
    fleet = Vehicles(instance, encoding)
    robots = range(1, len(fleet.rooms) + 1)
    u, v = potentials(instance, len(fleet.rooms) > 1)
    if encoding != "compact":
        u, v = [0.0] * (n + 1), [0.0] * (n + 1)
    u, v = [shift * x for x in u], [shift * x for x in v]

    def last(p: int) -> int:
        return {"full": n + 1, "reduced": n}.get(encoding, fleet.most[p - 1])

    first = 0 if encoding == "full" else 1

    def x(t: int, i: int, p: int) -> int:
        if encoding != "full" and t in (0, last(p) + 1):
            return int(i == 0)
        return sample.get(f"x[{t},{i},{p}]", 0)

    def way(i: int, j: int) -> float:
        if i == j and i > 0:
            return 0.0 if encoding == "compact" else d[i][i]
        return d[i][j] - u[i] - v[j]

    total = 0.0
    stays = 0
    for p in robots:
        if encoding == "compact" and last(p) == 0:
            continue
        final = last(p) if encoding == "full" else last(p) + 1
        for t in range(1, final + 1):
            for i in range(n + 1):
                for j in range(n + 1):
                    both = x(t - 1, i, p) * x(t, j, p)
                    total += way(i, j) * both
                    if i == 0 and j > 0 and t - 1 >= 1:
                        total += detour * both
        for t in range(first, last(p) + 1):
            total += step * (sum(x(t, i, p) for i in range(n + 1)) - 1) ** 2
        stays += last(p) + 1
    if encoding == "full":
        for t in (0, n + 1):
            total += step * (sum(x(t, 0, p) for p in robots) - len(robots)) ** 2
    # What the shift took off every feasible plan.
    total += sum(u[1:]) + sum(v[1:]) + (u[0] + v[0]) * (stays - n)

    def carried(i: int, p: int) -> int:
        return sum(x(t, i, p) for t in range(first, last(p) + 1))

    for i in range(1, n + 1):
        total += visit * (sum(carried(i, p) for p in robots) - 1) ** 2
    for p in robots:
        room = fleet.rooms[p - 1]
        mode = fleet.mode[p - 1] if encoding == "compact" else "sum"
        if mode == "sum":
            spare = room - (fleet.low[p - 1] if encoding == "compact" else 0)
            slack = sum(
                c * sample[f"slack[{p},{b}]"] for b, c in enumerate(slack_values(spare, kind))
            )
            load = sum(w[i] * carried(i, p) for i in range(1, n + 1))
            total += capacity * (load + slack - room) ** 2
        if mode == "pairs":
            for i, j in itertools.combinations(range(1, n + 1), 2):
                over = max(0, w[i] + w[j] - room)
                total += capacity * over**2 * carried(i, p) * carried(j, p)
    for nodes in instance.order_nodes:
        for i, j in itertools.combinations(nodes, 2):
            for p, q in itertools.permutations(robots, 2):
                total += same * carried(i, p) * carried(j, q)
    return total


# -- the tests ---------------------------------------------------------------------------------

PENALTIES = st.builds(
    Penalties,
    step=st.integers(0, 40),
    visit=st.integers(0, 40),
    capacity=st.integers(0, 8),
    same_robot=st.integers(0, 40),
    detour=st.integers(0, 5),
    shift=st.sampled_from([0.0, 0.5, 1.0]),
)


def agree(model: PickingModel, rows: np.ndarray) -> None:
    energies = model.bqm.energies((rows, model.variables))
    for row, found in zip(rows, energies, strict=True):
        sample = dict(zip(model.variables, row.tolist(), strict=True))
        expected = energy(model.instance, model.encoding, model.slack, model.penalties, sample)
        scale = max(1.0, abs(expected), float(np.abs(model.bqm.offset)))
        assert found == pytest.approx(expected, abs=1e-10 * scale)


def tiny(weights: list[int], capacities: list[int], lots: list[tuple[int, ...]]) -> Instance:
    return Instance(
        warehouse=OpenFloor(depot_x=1.0),
        items=tuple(
            Item(f"i{k + 1}", Fraction(w), Point(3.0 * k, 4.0 - k)) for k, w in enumerate(weights)
        ),
        orders=tuple(Order(f"o{o + 1}", tuple(f"i{i}" for i in lot)) for o, lot in enumerate(lots)),
        robots=tuple(Robot(f"R{k + 1}", Fraction(c)) for k, c in enumerate(capacities)),
    )


TINY = [
    (tiny([1], [1], [(1,)]), ENCODINGS),
    (tiny([1], [1, 1], [(1,)]), ENCODINGS),
    (tiny([1, 2], [4], [(1,), (2,)]), ("compact", "reduced")),
    (tiny([1, 2], [2, 2], [(1,), (2,)]), ("compact",)),
    (tiny([2, 1], [4, 3], [(1,), (2,)]), ("compact",)),
    (tiny([1, 1], [3, 2], [(1, 2)]), ("compact",)),
    (tiny([1, 1, 2], [3, 3], [(1,), (2,), (3,)]), ("compact",)),
    (tiny([2, 2], [3, 3], [(1,), (2,)]), ("compact",)),
    (tiny([3, 2, 2], [4, 4], [(1,), (2,), (3,)]), ("compact",)),
]


@pytest.mark.parametrize("slack", ["exact", "paper"])
@pytest.mark.parametrize(
    ("instance", "encoding"), [(i, e) for i, encodings in TINY for e in encodings]
)
def test_all_assignments_of_tiny_models(instance: Instance, encoding: str, slack: str) -> None:
    model = build_model(instance, encoding, slack=slack)
    count = 2**model.num_variables
    assert count <= 2**14
    chosen = np.arange(count)
    if count > 2**12 and encoding == "compact":
        chosen = np.random.default_rng(0).choice(count, 1_500, replace=False)
    agree(model, chosen[:, None] >> np.arange(model.num_variables) & 1)


@pytest.mark.parametrize("encoding", ENCODINGS)
@settings(max_examples=40)
@given(
    instance=instances(max_items=4, max_robots=3, multi_trip=True),
    penalties=PENALTIES,
    slack=st.sampled_from(["exact", "paper"]),
    seed=st.integers(0, 2**32 - 1),
)
def test_random_assignments(
    encoding: str, instance: Instance, penalties: Penalties, slack: str, seed: int
) -> None:
    try:
        model = build_model(instance, encoding, slack=slack, penalties=penalties)
    except InfeasibleError:
        assert encoding == "compact"
        return
    rng = np.random.default_rng(seed)
    shape = (4, model.num_variables)
    agree(model, (rng.random(shape) < rng.choice([0.1, 0.3, 0.6])).astype(np.int8))


def test_a_model_is_binary_and_in_double_precision() -> None:
    model = build_model(TINY[6][0])
    assert model.bqm.vartype is dimod.BINARY
    assert model.bqm.dtype == np.float64
    assert list(model.bqm.variables) == model.variables


def test_blocks_of_rows_make_the_same_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """Models that are too large for one block of rows are put together from several."""
    instance = tiny([3, 2, 4, 1], [8, 6], [(1, 2), (3,), (4,)])
    for encoding in ENCODINGS:
        whole = build_model(instance, encoding).bqm
        monkeypatch.setattr("qrobot.models.assemble.BLOCK", 60)
        assert build_model(instance, encoding).bqm == whole
        monkeypatch.undo()


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_shown_case_of_the_papers_slack(encoding: str) -> None:
    """M = 16, K = 2, all on robot 1: the paper's slack cannot absorb an empty robot."""
    instance = tiny([4, 6], [16, 16], [(1,), (2,)])
    weight = {"capacity": 100.0}
    exact = build_model(instance, encoding, penalties=weight)
    length = instance.length([[1, 2]])
    assert exact.energy_of([[1, 2]]) == pytest.approx(length)
    paper = build_model(instance, encoding, slack="paper", penalties=weight)
    extra = 0.0 if encoding == "compact" else 100.0
    assert paper.energy_of([[1, 2]]) == pytest.approx(length + extra)
    light = replace(instance, robots=(instance.robots[0], Robot("R2", Fraction(15))))
    assert build_model(light, "reduced", slack="paper", penalties=weight).energy_of(
        [[1, 2]]
    ) == pytest.approx(length)
