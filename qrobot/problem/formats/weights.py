"""TSPLIB's distances: functions of coordinates, and matrices in all their layouts.

Formulas as Reinelt's TSPLIB 95 gives them; where its text and the published optima disagree
(the degrees of GEO are cut off, not rounded), the optima count.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from qrobot._arrays import Floats
from qrobot.problem.formats.tsplib import Section

__all__ = ["LAYOUTS", "METRICS", "ROUNDINGS", "geographical", "pseudo_euclidean", "square_matrix"]


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
    """Return GEO distances, kilometres on an idealised sphere.

    Parameters
    ----------
    positions
        Latitude and longitude as DDD.MM, shape (n, 2).
    """
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
    """Return the matrix that the stream of an EDGE_WEIGHT_SECTION fills.

    Parameters
    ----------
    section
        The numbers, however they are broken into lines.
    layout
        One of `LAYOUTS`.
    size
        Number of nodes.

    Returns
    -------
    numpy.ndarray
        Shape (size, size); the diagonal is 0, whatever the file has there.

    Raises
    ------
    InputError
        When there are too few or too many numbers, or one is not a distance.
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


def unknown_type(name: str) -> str:
    """Return the advice for an EDGE_WEIGHT_TYPE that is not read."""
    return f"use EXPLICIT, GEO, ATT, {', '.join(METRICS)}" if name else "add it, such as EUC_2D"
