"""The sections of a TSPLIB text, checked line by line before `vrplib` reads them.

`vrplib` drops the node numbers, keeps text where numbers should be, and knows two of the
formats of an explicit matrix. So the numbers are checked here, where their line is known,
and the edge weights are read here as the one stream of numbers that TSPLIB 95 makes them.
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from qrobot.errors import InputError

__all__ = ["check_sections", "square_matrix"]

_WIDTHS = {"NODE_COORD": 3, "DEMAND": 2}
_KNOWN = {"NODE_COORD", "DEMAND", "DEPOT", "EDGE_WEIGHT", "DISPLAY_DATA"}
_LARGEST = 1e9

_TRIANGLES = {
    "LOWER_ROW": ("lower", 1),
    "UPPER_COL": ("lower", 1),
    "UPPER_ROW": ("upper", 1),
    "LOWER_COL": ("upper", 1),
    "LOWER_DIAG_ROW": ("lower", 0),
    "UPPER_DIAG_COL": ("lower", 0),
    "UPPER_DIAG_ROW": ("upper", 0),
    "LOWER_DIAG_COL": ("upper", 0),
}
"""For each format the triangle that its stream fills row by row, and whether the diagonal
is left out. Columns of one triangle are the rows of the other, since both are equal."""


def check_sections(text: str) -> tuple[str, list[float] | None]:
    """Check every number of the data sections.

    Returns
    -------
    tuple
        The text without its EDGE_WEIGHT_SECTION, and the numbers of that section.

    Raises
    ------
    InputError
        With section and line.
    """
    kept: list[str] = []
    weights: list[float] | None = None
    section, rows = "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if "EOF" in line:
            break
        if "_SECTION" in line:
            section, rows = line.strip(" \t:").removesuffix("_SECTION").upper(), 0
            if section not in _KNOWN:
                raise InputError(
                    "is more than qRobot plans for",
                    field=f"{section:.40}_SECTION",
                    mend="give a CVRP with capacities only",
                )
            if section == "EDGE_WEIGHT":
                weights = [] if weights is None else weights
                continue
        elif section:
            where = f"{section}_SECTION, line {number}"
            values = [_number(word, where) for word in words]
            if section == "EDGE_WEIGHT":
                assert weights is not None
                weights.extend(values)
                continue
            if section in _WIDTHS:
                rows += 1
                _check_row(values, rows, _WIDTHS[section], where)
        kept.append(line)
    return "\n".join(kept), weights


def _number(word: str, where: str) -> float:
    try:
        number = float(word)
    except ValueError:
        raise InputError(f"{word!r:.40} is not a number", field=where, mend="correct it") from None
    if not abs(number) <= _LARGEST:
        raise InputError(
            f"{word:.40} is not a number up to {_LARGEST:g}", field=where, mend="correct it"
        )
    return number


def _check_row(values: list[float], row: int, width: int, where: str) -> None:
    if len(values) != width:
        raise InputError(
            f"{len(values)} numbers where {width} belong", field=where, mend="correct the line"
        )
    if values[0] != row:
        raise InputError(
            f"node {values[0]:g} stands where node {row} belongs",
            field=where,
            mend="number the nodes 1, 2, 3 ... in sequence",
        )


def square_matrix(weights: list[float], layout: str, size: int) -> npt.NDArray[np.float64]:
    """Return the matrix that a stream of edge weights fills.

    Parameters
    ----------
    weights
        The numbers of the section, however they were broken into lines.
    layout
        EDGE_WEIGHT_FORMAT.
    size
        Number of nodes.

    Returns
    -------
    numpy.ndarray
        Shape (size, size).
    """
    if layout != "FULL_MATRIX" and layout not in _TRIANGLES:
        raise InputError(
            f"{layout:.40} is not known",
            field="EDGE_WEIGHT_FORMAT",
            mend=f"use FULL_MATRIX or one of {', '.join(itertools.islice(_TRIANGLES, 3))}",
        )
    triangle, offset = _TRIANGLES.get(layout, ("", 0))
    needed = size * (size + 1) // 2 - offset * size if triangle else size * size
    if len(weights) != needed:
        raise InputError(
            f"{len(weights)} weights where {layout} of {size} nodes has {needed}",
            field="EDGE_WEIGHT_SECTION",
            mend="correct DIMENSION, or complete the section (the file may be cut off)",
        )
    if not triangle:
        return np.array(weights).reshape(size, size)
    matrix = np.zeros((size, size))
    if triangle == "lower":
        matrix[np.tril_indices(size, -offset)] = weights
        return np.asarray(np.tril(matrix) + np.tril(matrix, -1).T)
    matrix[np.triu_indices(size, offset)] = weights
    return np.asarray(np.triu(matrix) + np.triu(matrix, 1).T)
