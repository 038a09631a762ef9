"""Where a tour starts and ends: at the depot, on a cross aisle, or at a slot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from qrobot.problem import AisleWarehouse, Slot
from qrobot.problem.checks import check_index, check_length
from qrobot.warehouse.grid import Grid
from qrobot.warehouse.inside import InAisle
from qrobot.warehouse.sweep import Door, Ends

__all__ = ["OnCrossAisle", "TourEnds", "ends_of"]


@dataclass(frozen=True, slots=True)
class OnCrossAisle:
    """A place on a cross aisle.

    Parameters
    ----------
    cross_aisle, aisle
        A crossing.
    offset
        Metres to its right, less than to the next aisle. Nobody comes to a place within a closed
        segment.
    """

    cross_aisle: int
    aisle: int
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class TourEnds:
    """Start and end of a tour as the sweep takes them.

    Parameters
    ----------
    kind
        Whether they are told apart.
    doors
        The crossings next to them.
    places
        Those in sub-aisles: 0 for the start or 1 for the end, and the place.
    direct
        Metres between start and end past no crossing, ``inf`` where there is one between them.
    """

    kind: Ends
    doors: tuple[Door, ...]
    places: dict[int, InAisle] = field(default_factory=dict)
    direct: float = np.inf


def ends_of(
    grid: Grid,
    warehouse: AisleWarehouse,
    start: Slot | OnCrossAisle | None,
    end: Slot | OnCrossAisle | None,
) -> TourEnds:
    """Return start and end of a tour; None is the depot.

    Raises
    ------
    InputError
        When the layout has no such place.
    """
    if start is None and end is None:
        return TourEnds(grid.ends, grid.doors, direct=0.0)
    doors: list[Door] = []
    places: dict[int, InAisle] = {}
    for which, place in enumerate((start, end)):
        if isinstance(place, Slot):
            warehouse.check(place)
            places[which] = place.aisle, place.block, warehouse.offset(place)
        elif place is None:
            doors += [door._replace(end=which) for door in grid.doors]
        else:
            doors += _next_to(place, which, grid, warehouse)
    return TourEnds(Ends.APART, tuple(doors), places, _direct(grid, warehouse, start, end))


def _next_to(
    place: OnCrossAisle, end: int, grid: Grid, warehouse: AisleWarehouse
) -> tuple[Door, ...]:
    """Return the crossings next to a place on a cross aisle."""
    check_index(place.aisle, "aisle", count=warehouse.aisles)
    check_index(place.cross_aisle, "cross_aisle", count=warehouse.blocks + 1)
    check_length(place.offset, "offset", most=warehouse.aisle_pitch)
    here = Door(place.aisle, place.cross_aisle, float(place.offset), end)
    if not place.offset:
        return (here,)
    check_index(place.aisle, "aisle", count=warehouse.aisles - 1)
    left = float(grid.across[place.aisle, place.cross_aisle]) - place.offset
    return () if left == np.inf else (here, Door(place.aisle + 1, place.cross_aisle, left, end))


def _direct(
    grid: Grid,
    warehouse: AisleWarehouse,
    start: Slot | OnCrossAisle | None,
    end: Slot | OnCrossAisle | None,
) -> float:
    """Return how far two places of one cross aisle are apart when no crossing is between."""
    if start == end:
        return 0.0
    w = warehouse
    away = 0.0 if start and end else w.depot_distance
    depot = OnCrossAisle(w.depot_cross_aisle, w.depot_aisle, w.depot_offset)
    stands = (depot if place is None else place for place in (start, end))
    on = [place for place in stands if isinstance(place, OnCrossAisle) and place.offset]
    if len(on) < 2 or (on[0].aisle, on[0].cross_aisle) != (on[1].aisle, on[1].cross_aisle):
        return np.inf
    open_ = np.isfinite(grid.across[on[0].aisle, on[0].cross_aisle])
    return away + abs(on[0].offset - on[1].offset) if open_ else np.inf
