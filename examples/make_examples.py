"""Make the examples: seeded, so that anyone gets the same files.

Run it from the project: ``python examples/make_examples.py [FOLDER]``.
"""

from __future__ import annotations

import csv
import io
import itertools
import json
import math
import random
import sys
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import qrobot
from qrobot._files import write_text_atomic
from qrobot.problem import (
    AisleWarehouse,
    Instance,
    Item,
    OpenFloor,
    Order,
    Point,
    Robot,
    Slot,
    Times,
)
from qrobot.problem.fleets import NO_LIMIT
from qrobot.problem.formats.jsontext import dumps
from qrobot.problem.formats.native import to_text

OURS = "Coordinates and orders are ours, drawn with seed {seed}; see examples/make_examples.py."

# Kilograms per piece as a shop for tools and household goods has them.
WEIGHTS = ["0.25", "0.4", "0.75", "1.2", "1.5", "2.5", "3.2", "4.8", "6", "7.5", "9", "12.5"]


def small_warehouse(seed: int = 2021) -> Instance:
    """Two blocks of ten aisles, 24 orders of one to four items, three robots 85 % full."""
    draw = random.Random(seed)
    warehouse = AisleWarehouse(
        aisles=10,
        blocks=2,
        slots=12,
        aisle_pitch=3.5,
        slot_pitch=0.9,
        end_gap=1.4,
        depot_aisle=4,
        depot_cross_aisle=0,
        depot_distance=2.5,
    )
    slots = [
        Slot(aisle, slot, block, side)
        for aisle in range(warehouse.aisles)
        for block in range(warehouse.blocks)
        for slot in range(warehouse.slots)
        for side in ("left", "right")
    ]
    stock = draw.sample(slots, 60)
    items: list[Item] = []
    orders: list[Order] = []
    for number in range(1, 25):
        lines = draw.choices([1, 2, 3, 4], weights=[3, 4, 3, 2])[0]
        ids = [f"{number:02}-{letter}" for letter in "abcd"[:lines]]
        places = draw.sample(stock, lines)
        # Light pieces are asked for most.
        loads = draw.choices(WEIGHTS, weights=range(len(WEIGHTS), 0, -1), k=lines)
        items += [Item(i, Fraction(w), p) for i, w, p in zip(ids, loads, places, strict=True)]
        orders.append(Order(f"order-{number:02}", tuple(ids)))
    total = sum(item.weight for item in items)
    capacity = Fraction(math.ceil(total / 3 / Fraction("0.85") * 2), 2)
    return Instance(
        warehouse=warehouse,
        items=tuple(items),
        orders=tuple(orders),
        robots=tuple(Robot(f"R{k}", capacity, speed=1.2) for k in (1, 2, 3)),
        name="small-warehouse",
        comment="Two blocks, ten aisles, 24 whole orders, three robots. " + OURS.format(seed=seed),
    )


def seven_spots(seed: int) -> list[Point]:
    """Return one sequence of places: the first items of all the small cases lie alike."""
    draw = random.Random(seed)
    return draw.sample([Point(x / 2, y / 2) for x in range(2, 40) for y in range(2, 28)], 7)


def paper(weights: Sequence[int], robots: int, capacity: int, seed: int = 7) -> Instance:
    """Return the paper's weights (figures 4 and 7) at coordinates of our own."""
    spots = seven_spots(seed)
    items = tuple(Item(str(i + 1), Fraction(w), spots[i]) for i, w in enumerate(weights))
    why = (
        "The capacity is that of the paper's captions: one robot can carry everything, so one "
        "robot is the shortest plan and the others stay home."
        if capacity == 45
        else "The paper's captions say 45, with which one robot carries everything; 15, the "
        "smallest capacity of its tables, makes two robots share the work."
    )
    return Instance(
        warehouse=OpenFloor(depot_x=0.0, depot_y=0.0, metric="euclidean"),
        items=items,
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=tuple(Robot(f"R{k + 1}", Fraction(capacity)) for k in range(robots)),
        name=f"paper-{len(weights)}-items" + ("-m45" if capacity == 45 else ""),
        comment=f"Weights of the paper. {why} Only the weights are the paper's: "
        f"the coordinates are ours, drawn with seed {seed}.",
    )


def three_items(seed: int = 7) -> Instance:
    """Return three items for one robot: nine qubits in the compact form."""
    spots = seven_spots(seed)[:3]
    items = tuple(Item(str(i + 1), Fraction(1), spot) for i, spot in enumerate(spots))
    return Instance(
        warehouse=OpenFloor(depot_x=0.0, depot_y=0.0, metric="euclidean"),
        items=items,
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=(Robot("R1", Fraction(3)),),
        name="three-items",
        comment="Small enough for every backend, gate-model simulators on an emulated Pi included: "
        f"9 qubits in the compact encoding. The coordinates are ours, drawn with seed {seed}.",
    )


def morning(seed: int = 5) -> Instance:
    """Eight orders with due times and a release, for two robots that come back."""
    draw = random.Random(seed)
    wishes: dict[str, dict[str, float]] = {
        "A": {"due": 150, "priority": 3},
        "B": {"due": 150},
        "C": {"due": 300},
        "D": {"due": 300},
        "E": {"due": 300},
        "F": {"release": 120},
        "G": {},
        "H": {"due": 400},
    }
    items, orders = [], []
    for k, (name, times) in enumerate(wishes.items()):
        own = tuple(f"{name}{j + 1}" for j in range(2 + k % 2))
        for item in own:
            pieces = draw.randint(1, 3)
            weight = pieces * Fraction(draw.choice(["0.5", "1.2", "2"]))
            place = Slot(draw.randrange(6), draw.randrange(10), draw.randrange(2))
            level = draw.choice([0, 0, 1, 2])
            items.append(Item(item, weight, place, quantity=pieces, level=level))
        orders.append(Order(name, own, **times))
    return Instance(
        AisleWarehouse(6, 10, 2, aisle_pitch=3.5, end_gap=1.5, depot_distance=2.0),
        tuple(items),
        tuple(orders),
        tuple(Robot(f"R{k + 1}", 14, 1.2, NO_LIMIT) for k in range(2)),
        name="morning",
        comment=OURS.format(seed=seed),
        times=Times(per_trip=20, per_pick=4, per_piece=1.5, per_level=3),
    )


def csv_orders(seed: int = 11) -> tuple[str, str]:
    """Return orders as CSV, one article in several orders, and their layout."""
    draw = random.Random(seed)
    warehouse = AisleWarehouse(
        aisles=6, slots=10, aisle_pitch=3.0, slot_pitch=1.0, end_gap=1.2, depot_distance=2.0
    )
    layout = Instance(
        warehouse=warehouse,
        items=(),
        orders=(),
        robots=(Robot("cart", Fraction(25), 1.0, trips=2), Robot("lift", Fraction(40), 0.8)),
        name="csv-layout",
        comment="The layout of orders.csv. " + OURS.format(seed=seed),
    )
    articles = [
        (f"SKU-{100 + n}", draw.choice(WEIGHTS[:9]), draw.randrange(6), draw.randrange(10), side)
        for n, side in enumerate(["left", "right"] * 6)
    ]
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["order", "item", "quantity", "weight", "aisle", "block", "slot", "side"])
    for number in range(1, 9):
        for name, weight, aisle, slot, side in draw.sample(articles, draw.randint(1, 3)):
            pieces = draw.choice([1, 1, 1, 2])
            rows.writerow([f"A{number}", name, pieces, weight, aisle, 0, slot, side])
    return out.getvalue(), to_layout(layout)


def wms_export(seed: int = 17) -> dict[str, str]:
    """Return the files of a warehouse management system: semicolons, decimal commas, labels."""
    draw = random.Random(seed)
    layout = Instance(
        warehouse=AisleWarehouse(
            aisles=8, blocks=2, slots=10, aisle_pitch=3.2, end_gap=1.3, depot_distance=2.0
        ),
        items=(),
        orders=(),
        robots=tuple(Robot(f"cart-{k}", Fraction(40), 1.2, trips=2) for k in (1, 2, 3)),
        name="wms-layout",
        comment="The layout of wms.csv. " + OURS.format(seed=seed),
    )
    bins = [
        # Aisle, bin and shelf, as painted on the racks: odd bins on the left.
        (f"{'ABCDEFGH'[aisle]}{1 + 2 * (10 * block + slot) + (side == 'right'):02}-{level + 1}",
         aisle, block, slot, side, level)
        for aisle in range(8)
        for block in range(2)
        for slot in range(10)
        for side in ("left", "right")
        for level in range(3)
    ]  # fmt: skip
    goods = [
        (f"{4000 + n}", draw.choice(WEIGHTS[:9]), draw.choice(["0.5", "1.25", "3"]), kind, one[0])
        for n, (kind, one) in enumerate(
            zip(["tools", "paint", "garden"] * 12, draw.sample(bins, 36), strict=True)
        )
    ]
    orders = [
        (f"SO-{number}", article, draw.choice([1, 1, 1, 2, 3]), label)
        for number in range(70_001, 70_021)
        for article, _, _, _, label in draw.sample(goods, draw.randint(1, 4))
    ]
    return {
        "wms.csv": _semicolons(("order", "article", "quantity", "place"), orders),
        "wms.articles.csv": _semicolons(
            ("article", "weight", "volume", "class"), [one[:4] for one in goods]
        ).replace(".", ","),
        "wms.locations.csv": _semicolons(
            ("label", "aisle", "block", "slot", "side", "level"), bins
        ),
        "wms.layout.json": to_layout(layout),
    }


def _semicolons(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    return "".join(";".join(map(str, row)) + "\n" for row in (head, *rows))


def to_layout(instance: Instance) -> str:
    """Return the native document of an instance without what only orders have."""
    document = json.loads(to_text(instance))
    del document["items"]
    return dumps(document)


def tiny_vrp(seed: int = 5, clients: int = 7, capacity: int = 20) -> tuple[str, str]:
    """Return a small CVRPLIB instance of our own, and its solution by trying everything."""
    draw = random.Random(seed)
    xy = draw.sample([(x, y) for x in range(60) for y in range(60)], clients + 1)
    demand = [0, *(draw.randint(2, 8) for _ in range(clients))]
    d = [[math.floor(math.dist(a, b) + 0.5) for b in xy] for a in xy]

    def tour(group: Sequence[int]) -> tuple[int, tuple[int, ...]]:
        return min(
            (sum(d[a][b] for a, b in itertools.pairwise((0, *order, 0))), order)
            for order in itertools.permutations(group)
        )

    def halves() -> Iterator[tuple[list[int], list[int]]]:
        for chosen in range(2 ** (clients - 1)):
            groups: tuple[list[int], list[int]] = ([], [])
            for node in range(1, clients + 1):
                groups[(chosen >> (node - 1)) & 1].append(node)
            if all(sum(demand[v] for v in group) <= capacity for group in groups):
                yield groups

    cost, routes = min(
        (sum(tour(group)[0] for group in groups), [tour(group)[1] for group in groups])
        for groups in halves()
    )
    name = f"tiny-n{clients + 1}-k2"
    lines = [
        f"NAME : {name}",
        f"COMMENT : (qRobot, our own with seed {seed}; No of trucks: 2, Optimal value: {cost})",
        "TYPE : CVRP",
        f"DIMENSION : {clients + 1}",
        "EDGE_WEIGHT_TYPE : EUC_2D",
        f"CAPACITY : {capacity}",
        "NODE_COORD_SECTION",
        *(f"{i} {x} {y}" for i, (x, y) in enumerate(xy, start=1)),
        "DEMAND_SECTION",
        *(f"{i} {w}" for i, w in enumerate(demand, start=1)),
        "DEPOT_SECTION",
        "1",
        "-1",
        "EOF",
    ]
    solution = [f"Route #{k}: {' '.join(map(str, r))}" for k, r in enumerate(routes, start=1)]
    return "\n".join(lines) + "\n", "\n".join([*solution, f"Cost {cost}"]) + "\n"


def main(folder: Path) -> None:
    """Write every example."""
    four, seven = [8, 8, 3, 3], [8, 8, 3, 3, 1, 2, 4]
    for instance in (
        small_warehouse(),
        paper(four, robots=2, capacity=15),
        paper(four, robots=3, capacity=45),
        paper(seven, robots=2, capacity=15),
        paper(seven, robots=3, capacity=45),
        three_items(),
        morning(),
    ):
        qrobot.write(instance, folder / f"{instance.name}.json")
    orders, layout = csv_orders()
    write_text_atomic(folder / "orders.csv", orders)
    write_text_atomic(folder / "layout.json", layout)
    for name, text in wms_export().items():
        write_text_atomic(folder / name, text)
    problem, solution = tiny_vrp()
    write_text_atomic(folder / "tiny.vrp", problem)
    write_text_atomic(folder / "tiny.sol", solution)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
