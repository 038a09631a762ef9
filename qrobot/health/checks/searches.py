"""The compiled search: shortest tours past picks of an aisle warehouse, against all sequences."""

import itertools

from qrobot.health.check import Check

PICKS = (((0, 3), (2, 9), (4, 0), (4, 7)), ((1, 5), (3, 1), (3, 8)))
"""Aisle and slot of the stops of two tours; the depot is before aisle 0, at the front."""
AISLES, SLOTS = 5, 10


def answer() -> list[float]:
    """Return the lengths of the tours that machine code finds."""
    from qrobot.problem import AisleWarehouse, Slot
    from qrobot.warehouse.routing import Router

    routing = Router(AisleWarehouse(AISLES, SLOTS), compiled=True)
    return [routing.length([Slot(aisle, slot) for aisle, slot in picks]) for picks in PICKS]


def expected() -> list[float]:
    """Return the lengths of the best sequences, with aisles 3 m, slots and ends 1 m apart."""
    end = SLOTS + 1

    def way(a: tuple[int, int], b: tuple[int, int]) -> int:
        if a[0] == b[0]:
            return abs(a[1] - b[1])
        return 3 * abs(a[0] - b[0]) + min(a[1] + b[1], 2 * end - a[1] - b[1])

    return [
        min(
            sum(map(way, [(0, 0), *tour], [*tour, (0, 0)]))
            for tour in itertools.permutations([(aisle, slot + 1) for aisle, slot in picks])
        )
        for picks in PICKS
    ]


CHECK = Check(
    __name__,
    title="compiled tours past 4 and 3 picks",
    group="solver",
    imports=("numba",),
    distributions=("qrobot", "numba"),
    source="all sequences of the picks",
    extra="planners",
)
