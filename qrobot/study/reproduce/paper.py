"""The paper: what its tables print, and instances in the shape of its rows at places of our own.

Rows, qubits and seconds of tables 1 to 3 are as printed. The paper prints seven weights (figures 4
and 7) and no coordinates. Table 1 (M = 45) takes
them as printed, in a sequence that has no common unit from the second item on: a common unit
would be divided out and save slack bits that the paper counts. Tables 2 and 3 (M = 15 and 25)
take them "normalised", as the paper puts it: divided by 3 and rounded up, so that one robot
can carry up to 9 (12) items. Items beyond the seventh weigh 1. Places are drawn with a seed.
"""

from __future__ import annotations

import csv
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Literal

from qrobot.models import PickingModel, build_model
from qrobot.models.penalties import Encoding
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

__all__ = [
    "DEVICES",
    "ENUMERATED",
    "FIGURE_WEIGHTS",
    "PLACES",
    "SEED",
    "TITLE",
    "YEAR",
    "PaperRow",
    "figure_instance",
    "paper_instance",
    "paper_rows",
    "penalty_model",
    "table_instance",
]

TITLE = (
    "qRobot: A Quantum computing approach in mobile robot order picking and batching problem "
    "solver optimization"
)
YEAR = 2021

DEVICES = {
    "dwave": "D-Wave (the caption calls all columns public simulators)",
    "braket_advantage_with_latency": (
        "D-Wave Advantage_system1 by Amazon Braket, waiting, queue and return included"
    ),
    "braket_advantage_run_only": "D-Wave Advantage_system1 by Amazon Braket, running time only",
    "ibmq_qasm_simulator": "ibmq_qasm_simulator by Qiskit",
    "pennylane": "PennyLane simulator",
}
"""The columns of ``paper.csv`` and the devices that the paper names for them."""

FIGURE_WEIGHTS = (8, 8, 3, 3, 1, 2, 4)
"""Of items 1 to 7 in the captions of figures 4 and 7, kilograms."""

KILOGRAMS = (8, 3, 8, 3, 1, 2, 4, 1, 1, 1, 1, 1)
NORMALISED = tuple(-(-weight // 3) for weight in KILOGRAMS)

ENUMERATED = 9
"""Most items whose plans are enumerated; beyond, they are counted by whole distances."""

CLEAR = 2.0
"""Metres between a node of a figure and the ways that pass it."""

SEED = 7
PLACES = (
    "The paper gives no coordinates: places, and so all distances, are ours, drawn with seed {seed}"
)


@dataclass(frozen=True, slots=True)
class PaperRow:
    """A row of one of the paper's tables.

    Parameters
    ----------
    table
        1, 2 or 3.
    robots, items, capacity
        K, n and M as printed.
    qubits
        As printed.
    seconds
        The paper's seconds by column of `DEVICES`; columns in which it prints "-" are left
        out.
    """

    table: int
    robots: int
    items: int
    capacity: int
    qubits: int
    seconds: dict[str, float]

    @property
    def encoding(self) -> Literal["full", "reduced"]:
        """The encoding that has the printed number of qubits."""
        return "full" if self.table == 1 else "reduced"

    @property
    def annealer(self) -> float | None:
        """The paper's seconds in the column of the annealer."""
        return next((s for c, s in self.seconds.items() if c.startswith(("dw", "braket"))), None)


@cache
def paper_rows(table: int) -> tuple[PaperRow, ...]:
    """Return the rows of a table, by number of items.

    Source: the tables of the paper (`TITLE`, `YEAR`), copied into ``paper.csv``. Table 3
    prints the gate columns of table 2 once more.
    """
    text = Path(__file__).with_name("paper.csv").read_text(encoding="utf-8")
    seconds: dict[tuple[int, int, int, int], dict[str, float]] = {}
    for line in csv.DictReader(text.splitlines()):
        if int(line["table"]) == table:
            names = ("robots", "items", "capacity", "qubits")
            key = tuple(int(line[name]) for name in names)
            seconds.setdefault(key, {})[line["column"]] = float(line["seconds"])  # type: ignore[arg-type]
    return tuple(PaperRow(table, *key, found) for key, found in sorted(seconds.items()))


def paper_instance(
    items: int,
    robots: int = 1,
    capacity: int | None = None,
    *,
    weights: Sequence[int] = NORMALISED,
    whole_metres: bool = False,
    seed: int = SEED,
) -> Instance:
    """Return an instance on a floor of 40 x 40 m with the depot in the middle.

    Parameters
    ----------
    items, robots
        n and K.
    capacity
        M; by default that of tables 2 and 3: 15 up to 9 items, then 25.
    weights
        Of the first items, at least n of them.
    whole_metres
        Whether distances are rounded to whole metres, as counting plans needs them.
    seed
        Of the places, which are multiples of half a metre; the first items of all sizes lie
        alike.
    """
    rng = random.Random(f"gate-row/{seed}")  # noqa: S311 - no secret
    places = [Point(rng.randint(0, 80) / 2, rng.randint(0, 80) / 2) for _ in range(items)]
    return _instance(
        [Item(f"i{k + 1}", Fraction(weights[k]), at) for k, at in enumerate(places)],
        robots,
        capacity or (15 if items < 10 else 25),
        OpenFloor(depot_x=20.0, depot_y=20.0, rounding="nearest" if whole_metres else "none"),
        f"gate-row-{items}-{robots}",
        seed,
    )


def _instance(
    items: Sequence[Item], robots: int, capacity: int, floor: OpenFloor, name: str, seed: int
) -> Instance:
    """Return an instance in which every item is an order and all robots are alike."""
    return Instance(
        warehouse=floor,
        items=tuple(items),
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=tuple(Robot(f"R{k + 1}", Fraction(capacity)) for k in range(robots)),
        name=name,
        comment=PLACES.format(seed=seed) + ".",
    )


def table_instance(row: PaperRow, seed: int = SEED) -> Instance:
    """Return the instance of a row of the paper's tables.

    From 10 items on distances are rounded to whole metres: plans are counted by distance.
    """
    weights = KILOGRAMS if row.table == 1 else NORMALISED
    return paper_instance(
        row.items,
        row.robots,
        row.capacity,
        weights=weights,
        whole_metres=row.items > ENUMERATED,
        seed=seed,
    )


def figure_instance(items: int, robots: int, capacity: int, seed: int = SEED) -> Instance:
    """Return the instance of figure 4 (4 items) or 7 (7 items) with any fleet.

    Places are drawn again until no way passes close to a third node, so that the graph can
    be read.
    """
    house = OpenFloor(depot_x=20.0, depot_y=20.0)
    spots = next(spots for spots in _drawn(items, seed) if _apart([house.depot, *spots]))
    made = [
        Item(str(k + 1), Fraction(FIGURE_WEIGHTS[k]), Point(x, y)) for k, (x, y) in enumerate(spots)
    ]
    return _instance(made, robots, capacity, house, f"Figure {items}, M = {capacity}", seed)


def _drawn(items: int, seed: int) -> Iterator[list[tuple[float, float]]]:
    rng = random.Random(f"figure/{items}/{seed}")  # noqa: S311 - no secret
    while True:
        yield [(rng.randint(0, 80) / 2, rng.randint(0, 80) / 2) for _ in range(items)]


def _apart(spots: list[tuple[float, float]]) -> bool:
    """Return whether every node is at least `CLEAR` metres from the ways between others."""
    for (ax, ay), (bx, by) in combinations(spots, 2):
        length = (bx - ax) ** 2 + (by - ay) ** 2
        if length < CLEAR**2:
            return False
        for x, y in spots:
            if (x, y) in {(ax, ay), (bx, by)}:
                continue
            along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length
            along = min(max(along, 0.0), 1.0)
            off = (x - ax - along * (bx - ax)) ** 2 + (y - ay - along * (by - ay)) ** 2
            if off < CLEAR**2:
                return False
    return True


def penalty_model(instance: Instance, encoding: Encoding = "reduced") -> PickingModel:
    """Return the paper's model with weights under which the lowest energy is the best plan.

    Gate-model searches aim at the lowest energy, so it must be the optimum: 2 d_max for steps
    and visits, a twentieth of that for capacity. Annealers get the weights that sample best
    (`Penalties.measured`).
    """
    step = 2.0 * float(instance.distances.max())
    weights = {"step": step, "visit": step, "capacity": step / 20}
    return build_model(instance, encoding, slack="paper", penalties=weights)
