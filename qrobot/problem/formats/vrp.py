"""CVRPLIB and QOBLIB files: ``.vrp`` instances and ``.sol`` solutions.

The text is parsed by the `vrplib` package. What it leaves open is settled here: EUC_2D is
rounded as TSPLIB demands, and the number of vehicles, which has no field, is taken from
the comment or the name.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import (
    MAX_ITEMS,
    MAX_STOPS,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Place,
    Point,
    Robot,
    Warehouse,
)
from qrobot.problem.formats.tsplib import check_sections, square_matrix
from qrobot.problem.units import exact

__all__ = ["read_solution", "read_vrp"]

Specs = dict[str, Any]

_TRUCKS = re.compile(r"(?:no\.?|number) of (?:trucks|vehicles)\s*[:=]?\s*(\d{1,6})", re.I)
_BEST = re.compile(
    r"(?:optimal|best(?:[ -]known)?)\s*(?:value|cost|solution|distance)?\s*[:=]\s*"
    r"(\d{1,12}(?:\.\d{1,12})?)",
    re.I,
)


def read_vrp(
    path: StrPath, *, robots_follow: bool = False, capacity: Fraction | None = None
) -> Instance:
    """Return the instance of a ``.vrp`` file.

    Items are named ``1`` to ``n``, the clients' numbers in ``.sol`` files: the nodes in
    their sequence without the depot.

    Parameters
    ----------
    path
        A CVRP with EUC_2D, MAN_2D, CEIL_2D, FLOOR_2D, EXACT_2D or EXPLICIT distances.
    robots_follow
        Whether the number of robots is set afterwards, so that the file need not tell it.
    capacity
        Takes the place of CAPACITY.

    Raises
    ------
    InputError
        When the file is broken, or asks for more than capacities.
    """
    path = Path(path)
    specs, weights = _parse(read_text(path, fallback="latin-1"))
    size = _whole(specs, "DIMENSION", least=1, most=MAX_STOPS + 1)
    demands = _section(specs, "DEMAND", size).tolist()
    depot = _depot(specs, size)
    if demands[depot]:
        raise InputError(
            f"the depot has demand {demands[depot]}", field="DEMAND_SECTION", mend="make it 0"
        )
    reference = _reference(path, str(specs.get("comment", "")))
    warehouse, places = _warehouse(specs, size, depot, weights, reference)
    items = tuple(
        Item(str(i + 1), exact(demands[node], field="DEMAND_SECTION"), places[node])
        for i, node in enumerate(node for node in range(size) if node != depot)
    )
    count = 1 if robots_follow else _count(path, specs)
    load = _capacity(specs) if capacity is None else capacity
    return Instance(
        warehouse=warehouse,
        items=items,
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=tuple(Robot(f"R{k + 1}", load) for k in range(count)),
        name=_printable(specs.get("name", "")) or path.stem,
        comment=_printable(specs.get("comment", "")),
        reference=reference,
    )


def read_solution(path: StrPath) -> tuple[list[list[int]], float]:
    """Return the routes of a ``.sol`` file, as numbers of clients, and its cost.

    Raises
    ------
    InputError
        When the file is no solution.
    """
    import vrplib.parse

    text = read_text(path, fallback="latin-1")
    source = str(path)
    try:
        data: dict[str, Any] = vrplib.parse.parse_solution(text)
    except Exception:  # vrplib raises whatever its first broken line leads to
        raise InputError(
            "is not a solution", source=source, mend="give lines such as 'Route #1: 3 1 2'"
        ) from None
    cost = data.get("cost")
    if not data["routes"] or not isinstance(cost, int | float):
        missing = "Cost" if data["routes"] else "Route"
        raise InputError("is missing", source=source, field=missing, mend="give routes and cost")
    return [list(route) for route in data["routes"]], float(cost)


def _parse(text: str) -> tuple[Specs, list[float] | None]:
    import vrplib.parse

    rest, weights = check_sections(text)
    try:
        specs: Specs = vrplib.parse.parse_vrplib(rest, compute_edge_weights=False)
    except Exception as error:  # whatever the first broken line leads to
        why = str(error).rstrip(".") or type(error).__name__
        raise InputError(
            f"is not in VRPLIB format ({why:.80})", mend="check it against TSPLIB 95"
        ) from None
    if str(specs.get("type", "CVRP")).upper() != "CVRP":
        raise InputError(f"{specs['type']!s:.40} is not planned", field="TYPE", mend="give a CVRP")
    for name in ("distance", "max_distance", "service_time"):
        if specs.get(name):
            raise InputError(
                f"{specs[name]!s:.40} is a limit that qRobot does not plan for",
                field=name.upper(),
                mend="give a CVRP with capacities only",
            )
    return specs, weights


def _whole(specs: Specs, name: str, *, least: int, most: int) -> int:
    value = specs.get(name.lower())
    if value is None:
        raise InputError("is missing", field=name, mend="add it; the file may be cut off")
    if not isinstance(value, int) or not least <= value <= most:
        raise InputError(
            f"{value!s:.40} is not a whole number from {least} to {most}",
            field=name,
            mend="correct it" if not isinstance(value, int) or value < least else "plan in waves",
        )
    return value


def _section(specs: Specs, name: str, size: int) -> npt.NDArray[Any]:
    """Return the rows of a section, without node numbers, as many as there are nodes."""
    if name.lower() not in specs:
        raise InputError(
            "is missing", field=f"{name}_SECTION", mend="add it; the file may be cut off"
        )
    rows = np.asarray(specs[name.lower()])
    if len(rows) != size:
        raise InputError(
            f"{len(rows)} nodes where DIMENSION says {size}",
            field=f"{name}_SECTION",
            mend="correct DIMENSION, or complete the section (the file may be cut off)",
        )
    return rows


def _depot(specs: Specs, size: int) -> int:
    found = np.asarray(specs.get("depot", [])).ravel().tolist()
    if len(found) != 1:
        raise InputError(
            f"{len(found)} depots where one belongs" if found else "names no depot",
            field="DEPOT_SECTION",
            mend="give one node, then -1",
        )
    if found[0] not in range(size):
        raise InputError(
            f"{found[0] + 1} is not a node", field="DEPOT_SECTION", mend=f"use 1 to {size}"
        )
    return int(found[0])


def _capacity(specs: Specs) -> Fraction:
    if "capacity" not in specs:
        raise InputError("is missing", field="CAPACITY", mend="add it, or give --capacity")
    capacity = exact(specs["capacity"], field="CAPACITY")
    if capacity <= 0:
        raise InputError(
            f"{specs['capacity']} is not positive", field="CAPACITY", mend="correct it"
        )
    return capacity


def _count(path: Path, specs: Specs) -> int:
    """Return the number of vehicles: VEHICLES, comment, name, file name, in this sequence."""
    if "vehicles" in specs:
        return _whole(specs, "VEHICLES", least=1, most=MAX_ITEMS)
    comment, name = str(specs.get("comment", "")), str(specs.get("name", ""))
    for pattern, text in ((_TRUCKS, comment), (r"-k(\d{1,6})", name), (r"-k(\d{1,6})", path.stem)):
        found = re.search(pattern, text)
        if found and 1 <= int(found[1]) <= MAX_ITEMS:
            return int(found[1])
    raise InputError(
        "the number of vehicles is neither in the comment nor, as -kN, in the name",
        field="COMMENT",
        mend="give the number of robots (--robots N, or --robots free)",
    )


def _reference(path: Path, comment: str) -> float | None:
    """Return the least value that the comment or a solution beside the file knows."""
    known = [float(found[1]) for found in [_BEST.search(comment)] if found]
    for ending in (".opt.sol", ".sol", ".bst.sol"):
        beside = path.with_name(path.stem + ending)
        if beside.is_file():
            try:
                known.append(read_solution(beside)[1])
            except InputError:
                continue  # no answer is needed to read a question
    return min(known, default=None)


def _warehouse(
    specs: Specs, size: int, depot: int, weights: list[float] | None, reference: float | None
) -> tuple[Warehouse, list[Place]]:
    """Return where things stand, and the place of every node."""
    kind = str(specs.get("edge_weight_type", "EXPLICIT" if weights else "")).upper()
    positions = None
    if kind != "EXPLICIT" or "node_coord" in specs:
        positions = _section(specs, "NODE_COORD", size).astype(np.float64)
    if kind in ("EUC_2D", "MAN_2D"):
        assert positions is not None
        # Sets whose values are fractions (CMT, Golden) were never rounded.
        whole = reference is None or reference.is_integer()
        x, y = positions[depot].tolist()
        metric = "euclidean" if kind == "EUC_2D" else "manhattan"
        floor = OpenFloor(x, y, metric, "nearest" if whole else "none")  # type: ignore[arg-type]
        return floor, [Point(x, y) for x, y in positions.tolist()]
    matrix = _matrix(specs, kind, size, weights, positions)
    drawn = None if positions is None else tuple((x, y) for x, y in positions.tolist())
    try:
        table = DistanceTable(tuple(map(tuple, matrix.tolist())), depot, drawn)
    except InputError as error:
        field = f"EDGE_WEIGHT_SECTION: {error.field}"
        raise InputError(error.problem, field=field, mend=error.mend) from None
    return table, [Node(i) for i in range(size)]


def _matrix(
    specs: Specs,
    kind: str,
    size: int,
    weights: list[float] | None,
    positions: npt.NDArray[np.float64] | None,
) -> npt.NDArray[np.float64]:
    if kind == "EXPLICIT":
        if weights is None:
            raise InputError("is missing", field="EDGE_WEIGHT_SECTION", mend="add it")
        return square_matrix(weights, str(specs.get("edge_weight_format", "")).upper(), size)
    rounded: dict[str, Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]] = {
        "CEIL_2D": np.ceil,
        "FLOOR_2D": np.floor,
        "EXACT_2D": lambda lengths: np.floor(1000 * lengths + 0.5),
    }
    if kind not in rounded:
        raise InputError(
            f"{kind:.40} is not known" if kind else "is missing",
            field="EDGE_WEIGHT_TYPE",
            mend=f"use EUC_2D, MAN_2D, EXPLICIT, {', '.join(rounded)}",
        )
    assert positions is not None
    steps = positions[:, None, :] - positions[None, :, :]
    # A root of the sum, not hypot: exact for whole squares, which ceil and floor need.
    lengths = np.sqrt((steps**2).sum(axis=2))
    return np.asarray(rounded[kind](lengths), dtype=np.float64)


def _printable(value: object) -> str:
    return "".join(c for c in str(value) if c.isprintable())[:200].strip()
