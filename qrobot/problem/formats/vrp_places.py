"""Where the nodes of a ``.vrp`` file stand, and how far apart they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem import DistanceTable, Node, OpenFloor, Place, Point, Warehouse
from qrobot.problem.checks import MAX_LENGTH
from qrobot.problem.floor import coarse
from qrobot.problem.formats.tsplib import Tsplib
from qrobot.problem.formats.weights import (
    LAYOUTS,
    METRICS,
    ROUNDINGS,
    geographical,
    pseudo_euclidean,
    square_matrix,
)

__all__ = ["Places", "places_of"]


@dataclass(frozen=True, slots=True)
class Places:
    """Where things stand."""

    warehouse: Warehouse
    nodes: list[Place]
    whole: bool
    """Whether distances were rounded to whole numbers."""


def places_of(
    file: Tsplib, size: int, depot: int, own: float | None, rounding: str | None
) -> Places:
    """Return where the nodes stand, and their distances.

    Parameters
    ----------
    file
        The file; gets notes.
    size, depot
        Number of nodes, and which is the depot, from 0.
    own
        The least distance that the file itself knows.
    rounding
        Takes the place of what EDGE_WEIGHT_TYPE demands.

    Raises
    ------
    InputError
        With the place in the file.
    """
    kind = _kind(file)
    if rounding is not None and kind not in METRICS:
        raise InputError(
            f"EDGE_WEIGHT_TYPE {kind} leaves nothing to round",
            field="rounding",
            advice="leave it out",
        )
    positions = None
    if kind != "EXPLICIT" or "NODE_COORD" in file.sections:
        positions = _positions(file, size, kind)
    if kind in METRICS:
        assert positions is not None
        return _on_floor(file, kind, depot, positions, _rounding(file, kind, own, rounding))
    if kind == "EXPLICIT":
        matrix = _explicit(file, size)
    else:
        assert positions is not None
        matrix = (geographical if kind == "GEO" else pseudo_euclidean)(positions)
    return _in_table(matrix, depot, positions, whole=kind != "EXPLICIT")


def _kind(file: Tsplib) -> str:
    kind = file.text("EDGE_WEIGHT_TYPE").upper()
    weights = file.sections.get("EDGE_WEIGHT")
    if not kind and weights is not None:
        kind = "EXPLICIT"
    if kind not in {*METRICS, "EXPLICIT", "GEO", "ATT"}:
        advice = f"use EXPLICIT, GEO, ATT, {', '.join(METRICS)}"
        field = file.fields.get("EDGE_WEIGHT_TYPE")
        if field is None:
            raise InputError("is missing", field="EDGE_WEIGHT_TYPE", advice=advice)
        raise field.error(f"{kind:.40} is not known" if kind else "is empty", advice)
    if kind != "EXPLICIT" and weights is not None:
        raise weights.error(f"stands beside EDGE_WEIGHT_TYPE {kind}", "keep one of them")
    return kind


def _in_table(matrix: Floats, depot: int, positions: Floats | None, *, whole: bool) -> Places:
    drawn = None if positions is None else tuple((x, y) for x, y in positions[:, :2].tolist())
    table = DistanceTable(tuple(map(tuple, matrix.tolist())), depot, drawn)
    return Places(table, [Node(i) for i in range(len(matrix))], whole)


def _rounding(file: Tsplib, kind: str, own: float | None, asked: str | None) -> str | None:
    """Return the rounding that replaces the one of EDGE_WEIGHT_TYPE, None without one."""
    if asked is not None or own is None or own.is_integer() or kind not in ("EUC_2D", "MAN_2D"):
        return asked
    # Sets whose values are fractions (CMT, Golden) were never rounded.
    file.notes.append(
        f"distances are not rounded, because the comment knows {own:g}, which is not whole "
        "(rounding nearest rounds them)"
    )
    return "none"


def _on_floor(file: Tsplib, kind: str, depot: int, positions: Floats, asked: str | None) -> Places:
    whole = asked != "none"
    if kind in ("EUC_2D", "MAN_2D") and asked in (None, "none", "nearest"):
        x, y = positions[depot].tolist()
        floor = OpenFloor(
            x,
            y,
            "euclidean" if kind == "EUC_2D" else "manhattan",
            "nearest" if whole else "none",
        )
        return Places(floor, [Point(x, y) for x, y in positions.tolist()], whole)
    length, rounded = METRICS[kind]
    lengths = length(positions[:, None, :] - positions[None, :, :])
    matrix = (rounded if asked is None else ROUNDINGS[asked])(lengths)
    file.notes.extend(coarse(matrix, lambda: lengths, kind))
    return _in_table(matrix, depot, positions, whole=whole)


def _positions(file: Tsplib, size: int, kind: str) -> Floats:
    """Return the coordinates, shape (size, 2) or, for 3D kinds, (size, 3)."""
    solid = kind.endswith("_3D") or (
        kind == "EXPLICIT" and file.text("NODE_COORD_TYPE").upper() == "THREED_COORDS"
    )
    words, rows = file.nodes("NODE_COORD", size, 4 if solid else 3)
    positions = np.array([line[1:] for line in words], dtype=np.float64)
    bad = np.argwhere(~(np.abs(positions) <= MAX_LENGTH))
    for node, axis in bad[:1].tolist():
        raise file.sections["NODE_COORD"].error(
            f"{words[node][axis + 1]:.40} is not a number up to {MAX_LENGTH:g}",
            "correct it",
            rows[node],
            axis + 1,
        )
    return positions


def _explicit(file: Tsplib, size: int) -> Floats:
    section = file.sections.get("EDGE_WEIGHT")
    if section is None:
        raise InputError("is missing", field="EDGE_WEIGHT_SECTION", advice="add it")
    field = file.fields.get("EDGE_WEIGHT_FORMAT")
    advice = f"use one of {', '.join(LAYOUTS)}"
    if field is None:
        raise InputError("is missing", field="EDGE_WEIGHT_FORMAT", advice=advice)
    layout = field.value.upper()
    if layout not in LAYOUTS:
        raise field.error(f"{layout:.40} is not known", advice)
    return square_matrix(section, layout, size)
