"""Where the nodes of a ``.vrp`` file stand, and how far apart they are.

Formulas as Reinelt's TSPLIB 95 gives them; where its text and the published optima disagree
(the degrees of GEO are cut off, not rounded), the optima count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem import DistanceTable, Node, OpenFloor, Place, Point, Warehouse
from qrobot.problem.checks import MAX_LENGTH
from qrobot.problem.floor import coarse
from qrobot.problem.formats.tsplib import Section, Tsplib

__all__ = ["ROUNDINGS", "Places", "places_of"]


LAYOUTS = {
    "FULL_MATRIX": ("", 0),
    "LOWER_ROW": ("lower", 1),
    "UPPER_COL": ("lower", 1),
    "UPPER_ROW": ("upper", 1),
    "LOWER_COL": ("upper", 1),
    "LOWER_DIAG_ROW": ("lower", 0),
    "UPPER_DIAG_COL": ("lower", 0),
    "UPPER_DIAG_ROW": ("upper", 0),
    "LOWER_DIAG_COL": ("upper", 0),
}
"""For each EDGE_WEIGHT_FORMAT the triangle that its stream fills row by row, and whether the
diagonal is left out. Columns of one triangle are the rows of the other, since both are equal."""

ROUNDINGS: dict[str, Callable[[Floats], Floats]] = {
    "none": lambda lengths: lengths,
    "nearest": lambda lengths: np.floor(lengths + 0.5),
    "up": np.ceil,
    "down": np.floor,
}


def _exact(lengths: Floats) -> Floats:
    """Thousandths as whole numbers, as the DIMACS challenge has them."""
    return np.floor(1000 * lengths + 0.5)


def _euclidean(steps: Floats) -> Floats:
    # A root of the sum, not hypot: exact for whole squares, which up and down need.
    return np.asarray(np.sqrt((steps**2).sum(axis=2)))


def _manhattan(steps: Floats) -> Floats:
    return np.asarray(np.abs(steps).sum(axis=2))


def _maximum(steps: Floats) -> Floats:
    """Each coordinate is rounded by itself; the largest of whole numbers is whole."""
    return np.asarray(np.abs(steps).max(axis=2))


METRICS: dict[str, tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]] = {
    "EUC_2D": (_euclidean, ROUNDINGS["nearest"]),
    "EUC_3D": (_euclidean, ROUNDINGS["nearest"]),
    "MAN_2D": (_manhattan, ROUNDINGS["nearest"]),
    "MAN_3D": (_manhattan, ROUNDINGS["nearest"]),
    "MAX_2D": (_maximum, ROUNDINGS["nearest"]),
    "MAX_3D": (_maximum, ROUNDINGS["nearest"]),
    "CEIL_2D": (_euclidean, ROUNDINGS["up"]),
    "FLOOR_2D": (_euclidean, ROUNDINGS["down"]),
    "EXACT_2D": (_euclidean, _exact),
}
"""For each EDGE_WEIGHT_TYPE the length of a step, shape (n, n, 2 or 3), and its rounding."""


def geographical(positions: Floats) -> Floats:
    """Return GEO distances, kilometres on an idealised sphere, of latitude and longitude DDD.MM."""
    degrees = np.trunc(positions)
    latitude, longitude = (3.141592 * (degrees + 5.0 * (positions - degrees) / 3.0) / 180.0).T
    q1 = np.cos(longitude[:, None] - longitude[None, :])
    q2 = np.cos(latitude[:, None] - latitude[None, :])
    q3 = np.cos(latitude[:, None] + latitude[None, :])
    cosine = np.clip(0.5 * ((1.0 + q1) * q2 - (1.0 - q1) * q3), -1.0, 1.0)
    return np.asarray(np.floor(6378.388 * np.arccos(cosine) + 1.0))


def pseudo_euclidean(positions: Floats) -> Floats:
    """Return ATT distances: a tenth of the square under the root, rounded up."""
    steps = positions[:, None, :] - positions[None, :, :]
    return np.asarray(np.ceil(np.sqrt((steps**2).sum(axis=2) / 10.0)))


def square_matrix(section: Section, layout: str, size: int) -> Floats:
    """Return the matrix that the stream of an EDGE_WEIGHT_SECTION fills, one of `LAYOUTS`.

    Its diagonal is 0, whatever the file has there.
    """
    weights = section.stream()
    triangle, offset = LAYOUTS[layout]
    needed = size * (size + 1) // 2 - offset * size if triangle else size * size
    if len(weights) != needed:
        raise section.error(
            f"{len(weights)} weights where {layout} of {size} nodes has {needed}",
            "correct DIMENSION, or complete the section (the file may be cut off)",
        )
    # Where in the stream each entry stands: it fills the matrix, and finds a fault again.
    at = np.zeros((size, size), dtype=np.intp)
    order = np.arange(len(weights))
    if not triangle:
        at = order.reshape(size, size)
    elif triangle == "lower":
        at[np.tril_indices(size, -offset)] = order
        at = np.tril(at) + np.tril(at, -1).T
    else:
        at[np.triu_indices(size, offset)] = order
        at = np.triu(at) + np.triu(at, 1).T
    if not len(weights):
        return np.zeros((size, size))
    matrix = weights[at]
    np.fill_diagonal(matrix, 0.0)
    bad = np.argwhere(~(matrix >= 0))
    for i, j in bad[:1].tolist():
        raise section.error_at(
            int(at[i, j]),
            f"{matrix[i, j]:g} is not 0 or more (from node {i + 1} to {j + 1})",
            "correct the distance",
        )
    return matrix


@dataclass(frozen=True, slots=True)
class Places:
    """Where things stand."""

    warehouse: Warehouse
    nodes: list[Place]
    rounded: bool
    """Whether distances were rounded to whole numbers."""


def places_of(
    file: Tsplib, size: int, depot: int, own: float | None, rounding: str | None
) -> Places:
    """Return where the nodes stand, and their distances; the file gets notes.

    `depot` counts from 0, `own` is the least distance that the file itself knows, `rounding`
    takes the place of what EDGE_WEIGHT_TYPE demands.
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
    return _in_table(matrix, depot, positions, rounded=kind != "EXPLICIT")


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


def _in_table(matrix: Floats, depot: int, positions: Floats | None, *, rounded: bool) -> Places:
    drawn = None if positions is None else tuple((x, y) for x, y in positions[:, :2].tolist())
    table = DistanceTable(tuple(map(tuple, matrix.tolist())), depot, drawn)
    return Places(table, [Node(i) for i in range(len(matrix))], rounded)


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
    rounded = asked != "none"
    if kind in ("EUC_2D", "MAN_2D") and asked in (None, "none", "nearest"):
        x, y = positions[depot].tolist()
        floor = OpenFloor(
            x,
            y,
            "euclidean" if kind == "EUC_2D" else "manhattan",
            "nearest" if rounded else "none",
        )
        return Places(floor, [Point(x, y) for x, y in positions.tolist()], rounded)
    length, rule = METRICS[kind]
    lengths = length(positions[:, None, :] - positions[None, :, :])
    matrix = (rule if asked is None else ROUNDINGS[asked])(lengths)
    file.notes.extend(coarse(matrix, lambda: lengths, kind))
    return _in_table(matrix, depot, positions, rounded=rounded)


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
