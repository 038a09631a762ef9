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


class Reading:
    """A sample as the encoding means it."""

    def __init__(self, instance: Instance, encoding: str, sample: dict[str, int]) -> None:
        self.instance, self.encoding, self.sample = instance, encoding, sample
        self.fleet = Vehicles(instance, encoding)
        self.robots = range(1, len(self.fleet.rooms) + 1)
        self.items = range(1, instance.size + 1)
        self.first = 0 if encoding == "full" else 1

    def last(self, p: int) -> int:
        n = self.instance.size
        return {"full": n + 1, "reduced": n}.get(self.encoding, self.fleet.most[p - 1])

    def x(self, t: int, i: int, p: int) -> int:
        if self.encoding != "full" and t in (0, self.last(p) + 1):
            return int(i == 0)
        return self.sample.get(f"x[{t},{i},{p}]", 0)

    def carried(self, i: int, p: int) -> int:
        return sum(self.x(t, i, p) for t in range(self.first, self.last(p) + 1))


def energy(
    instance: Instance, encoding: str, kind: str, weight: Penalties, sample: dict[str, int]
) -> float:
    """The energy of a sample of a model, summed term by term."""
    read = Reading(instance, encoding, sample)
    total = energy_of_ways(read, weight)
    for i in read.items:
        total += weight.visit * (sum(read.carried(i, p) for p in read.robots) - 1) ** 2
    total += weight.capacity * excess(read, kind)
    for nodes in instance.order_nodes:
        for i, j in itertools.combinations(nodes, 2):
            for p, q in itertools.permutations(read.robots, 2):
                total += weight.same_robot * read.carried(i, p) * read.carried(j, q)
    return total


def energy_of_ways(read: Reading, weight: Penalties) -> float:
    """The ways, their detours and the steps, with the shift given back."""
    n, encoding = read.instance.size, read.encoding
    d = read.instance.distances.tolist()
    u, v = potentials(read.instance, len(read.fleet.rooms) > 1)
    if encoding != "compact":
        u, v = [0.0] * (n + 1), [0.0] * (n + 1)
    u, v = [weight.shift * x for x in u], [weight.shift * x for x in v]

    def way(i: int, j: int) -> float:
        if i == j and i > 0:
            return 0.0 if encoding == "compact" else d[i][i]
        return d[i][j] - u[i] - v[j]

    total = 0.0
    stays = 0
    for p in read.robots:
        if encoding == "compact" and read.last(p) == 0:
            continue
        final = read.last(p) if encoding == "full" else read.last(p) + 1
        for t, i, j in itertools.product(range(1, final + 1), range(n + 1), range(n + 1)):
            detour = weight.detour if i == 0 and j > 0 and t > 1 else 0
            total += (way(i, j) + detour) * read.x(t - 1, i, p) * read.x(t, j, p)
        for t in range(read.first, read.last(p) + 1):
            total += weight.step * (sum(read.x(t, i, p) for i in range(n + 1)) - 1) ** 2
        stays += read.last(p) + 1
    if encoding == "full":
        for t in (0, n + 1):
            home = sum(read.x(t, 0, p) for p in read.robots)
            total += weight.step * (home - len(read.robots)) ** 2
    # What the shift took off every feasible plan.
    return total + sum(u[1:]) + sum(v[1:]) + (u[0] + v[0]) * (stays - n)


def excess(read: Reading, kind: str) -> float:
    """The squares by which loads and slacks differ from what the robots carry."""
    w = [0, *(int(x) for x in read.instance.weights)]
    compact = read.encoding == "compact"
    total = 0.0
    for p in read.robots:
        room = read.fleet.rooms[p - 1]
        mode = read.fleet.mode[p - 1] if compact else "sum"
        if mode == "sum":
            spare = room - (read.fleet.low[p - 1] if compact else 0)
            slack = sum(
                c * read.sample[f"slack[{p},{b}]"] for b, c in enumerate(slack_values(spare, kind))
            )
            total += (sum(w[i] * read.carried(i, p) for i in read.items) + slack - room) ** 2
        if mode == "pairs":
            for i, j in itertools.combinations(read.items, 2):
                over = max(0, w[i] + w[j] - room)
                total += over**2 * read.carried(i, p) * read.carried(j, p)
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
