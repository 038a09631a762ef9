"""CVRPLIB and QOBLIB files: ``.vrp`` instances, in the words of TSPLIB 95.

What a file says is read or refused: a field or section that changes the question, such as a
limit of the trips' length, is never passed over, and one that nobody knows might. The number
of vehicles, which has no field of its own, is taken from the comment or the name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

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
from qrobot.problem.checks import MAX_LENGTH
from qrobot.problem.coarse import coarse
from qrobot.problem.formats.places import checked
from qrobot.problem.formats.solutions import reference_beside, reference_in_comment
from qrobot.problem.formats.tsplib import Tsplib, parse
from qrobot.problem.formats.weights import (
    LAYOUTS,
    METRICS,
    ROUNDINGS,
    geographical,
    pseudo_euclidean,
    square_matrix,
)
from qrobot.problem.names import first_invisible
from qrobot.problem.units import exact

__all__ = ["read_vrp"]

Floats = npt.NDArray[np.float64]

_READ = {
    "NAME", "COMMENT", "TYPE", "DIMENSION", "CAPACITY", "VEHICLES", "EDGE_WEIGHT_TYPE",
    "EDGE_WEIGHT_FORMAT", "NODE_COORD_TYPE",
}  # fmt: skip
_WITHOUT_MEANING = {"DISPLAY_DATA_TYPE"}
"""Only for pictures of other programs."""
_DESCRIBING = {
    "AUTHOR", "AUTHORS", "CONTACT", "CREATED", "CREATOR", "DATE", "DESCRIPTION", "EMAIL",
    "GENERATOR", "KEYWORDS", "LICENCE", "LICENSE", "NOTE", "NOTES", "ORIGIN", "PUBLISHED",
    "REMARK", "REMARKS", "SEED", "SOURCE", "TITLE", "URL", "VERSION", "YEAR",
}  # fmt: skip
_ZERO_IS_NONE = {
    "DISTANCE", "MAX_DISTANCE", "SERVICE_TIME", "VEHICLES_FIXED_COST", "VEHICLES_MAX_RELOADS",
}  # fmt: skip
"""Fields that files carry with 0 where there is no such limit, time, price or reload."""
_SECTIONS = {"NODE_COORD", "DEMAND", "DEPOT", "EDGE_WEIGHT", "DISPLAY_DATA"}

_TRUCKS = re.compile(
    r"(?:no\.?|number) of (?:trucks|vehicles)\s*[:=]?\s*(\d{1,6})(?![\d_'’]|[.,]\d)", re.IGNORECASE
)


def read_vrp(
    path: StrPath,
    *,
    robots_follow: bool = False,
    capacity: Fraction | None = None,
    rounding: str | None = None,
) -> Instance:
    """Return the instance of a ``.vrp`` file.

    Items are named ``1`` to ``n``, the clients' numbers in ``.sol`` files: the nodes in
    their sequence without the depot.

    Parameters
    ----------
    path
        A CVRP or ACVRP with distances that TSPLIB 95 knows.
    robots_follow
        Whether the number of robots is set afterwards, so that the file need not tell it.
    capacity
        Takes the place of CAPACITY.
    rounding
        ``none``, ``nearest``, ``up`` or ``down`` in the place of what EDGE_WEIGHT_TYPE
        demands.

    Raises
    ------
    InputError
        When the file is broken, or asks for more than capacities.
    """
    path = Path(path)
    file = parse(read_text(path, fallback="latin-1"))
    _check_known(file)
    size = _whole(file, "DIMENSION", most=MAX_STOPS + 1)
    demands, rows = _demands(file, size)
    depot = _depot(file, size)
    if demands[depot]:
        raise file.sections["DEMAND"].error(
            f"the depot has demand {float(demands[depot]):g}", "make it 0", rows[depot], 1
        )
    own, notes = reference_in_comment(file.text("COMMENT"))
    file.notes.extend(notes)
    places = _places(file, size, depot, own, rounding)
    clients = [node for node in range(size) if node != depot]
    items = tuple(
        Item(str(i + 1), demands[node], places.nodes[node]) for i, node in enumerate(clients)
    )
    count = 1 if robots_follow else _count(path, file)
    load = _capacity(file) if capacity is None else capacity

    def make() -> Instance:
        return Instance(
            warehouse=places.warehouse,
            items=items,
            orders=tuple(Order(item.id, (item.id,)) for item in items),
            robots=tuple(Robot(f"R{k + 1}", load) for k in range(count)),
            name=_name(file) or path.stem,
            comment=_printable(file.text("COMMENT")),
            reference=_reference(path, file, own, places.whole),
            remarks=tuple(file.notes),
        )

    def where(field: str) -> str:
        return _where(file, rows, clients, field)

    return checked(make, where)


def _where(file: Tsplib, rows: list[int], clients: list[int], field: str) -> str:
    """Return the place in the file of what the domain calls ``items[3].weight``."""
    found = re.match(r"items\[(\d+)\]", field)
    if found is None:
        return field
    return file.sections["DEMAND"].where(rows[clients[int(found[1])]], 1)


def _check_known(file: Tsplib) -> None:
    """Refuse what changes the question, note what only describes the file."""
    for field in file.fields.values():
        if field.name in _READ | _WITHOUT_MEANING:
            continue
        if field.name in _DESCRIBING:
            file.notes.append(f"the field {field.name} (line {field.line}) is not read")
        elif field.name not in _ZERO_IS_NONE or not re.fullmatch(r"0+(\.0*)?", field.value):
            raise field.error(
                f"{field.value:.40} asks for something that qRobot does not plan for",
                "give a CVRP with capacities only, or remove the field if plans may ignore it",
            )
    for section in file.sections.values():
        if section.name not in _SECTIONS:
            raise section.error("is more than qRobot plans for", "give a CVRP with capacities only")
    kind = (file.text("TYPE").upper().split() or ["CVRP"])[0]
    if kind not in ("CVRP", "ACVRP"):
        raise file.fields["TYPE"].error(f"{kind:.40} is not planned", "give a CVRP or an ACVRP")


def _whole(file: Tsplib, name: str, *, most: int) -> int:
    if name not in file.fields:
        raise InputError("is missing", field=name, mend="add it; the file may be cut off")
    field = file.fields[name]
    whole = re.fullmatch(r"[0-9]{1,12}", field.value)
    if whole is None or not 1 <= int(field.value) <= most:
        large = whole is not None and int(field.value) > most
        raise field.error(
            f"{field.value:.40} is not a whole number from 1 to {most}",
            "plan in waves" if large else "correct it",
        )
    return int(field.value)


def _table(file: Tsplib, name: str, size: int, width: int) -> tuple[list[list[str]], list[int]]:
    """Return the words of each node of a section, and the row that it stands in."""
    section = file.sections.get(name)
    if section is None:
        raise InputError(
            "is missing", field=f"{name}_SECTION", mend="add it; the file may be cut off"
        )
    words = section.table(width)
    if len(words) != size:
        raise section.error(
            f"{len(words)} nodes where DIMENSION says {size}",
            "correct DIMENSION, or complete the section (the file may be cut off)",
        )
    rows = [-1] * size
    for row, (node, *_) in enumerate(words):
        if not re.fullmatch(r"[0-9]{1,9}", node) or not 1 <= int(node) <= size:
            raise section.error(f"{node:.40} is not a node", f"use 1 to {size}", row)
        if (before := rows[int(node) - 1]) >= 0:
            line = section.rows[before][0]
            raise section.error(
                f"node {node} is in line {line} too", "number the nodes 1, 2, 3 ...", row
            )
        rows[int(node) - 1] = row
    return [words[row] for row in rows], rows


def _demands(file: Tsplib, size: int) -> tuple[list[Fraction], list[int]]:
    words, rows = _table(file, "DEMAND", size, 2)
    demands = []
    for (_, word), row in zip(words, rows, strict=True):
        try:
            demand = exact(word, field="")
        except InputError as error:
            raise file.sections["DEMAND"].error(
                error.problem, error.mend or "correct it", row, 1
            ) from None
        if demand < 0:
            raise file.sections["DEMAND"].error(
                f"the demand {word:.40} is negative", "use zero or more", row, 1
            )
        demands.append(demand)
    return demands, rows


def _depot(file: Tsplib, size: int) -> int:
    section = file.sections.get("DEPOT")
    numbers = [] if section is None else section.stream().tolist()
    end = numbers.index(-1.0) if -1.0 in numbers else len(numbers)
    if section is None or not end:
        raise (
            InputError("names no depot", field="DEPOT_SECTION", mend="give one node, then -1")
            if section is None
            else section.error("names no depot", "give one node, then -1")
        )
    if end > 1 or len(numbers) > end + 1:
        count = end if end > 1 else len(numbers) - 1
        raise section.error(f"{count} depots where one belongs", "give one node, then -1")
    if numbers[0] not in range(1, size + 1):
        raise section.error_at(0, f"{numbers[0]:g} is not a node", f"use 1 to {size}")
    return int(numbers[0]) - 1


def _capacity(file: Tsplib) -> Fraction:
    if "CAPACITY" not in file.fields:
        raise InputError("is missing", field="CAPACITY", mend="add it, or give --capacity")
    field = file.fields["CAPACITY"]
    try:
        capacity = exact(field.value, field="")
    except InputError as error:
        raise field.error(error.problem, error.mend or "correct it") from None
    if capacity <= 0:
        raise field.error(f"{field.value} is not positive", "correct it")
    return capacity


def _count(path: Path, file: Tsplib) -> int:
    """Return the number of vehicles: VEHICLES, comment, name, file name, in this sequence."""
    if "VEHICLES" in file.fields:
        return _whole(file, "VEHICLES", most=MAX_ITEMS)
    comment, name = file.text("COMMENT"), file.text("NAME")
    for pattern, text in ((_TRUCKS, comment), (r"-k(\d{1,6})", name), (r"-k(\d{1,6})", path.stem)):
        found = re.search(pattern, text)
        if found and 1 <= int(found[1]) <= MAX_ITEMS:
            return int(found[1])
    raise InputError(
        "the number of vehicles is neither in the comment nor, as -kN, in the name",
        field="COMMENT",
        mend="give the number of robots (--robots N, or --robots free)",
    )


def _reference(path: Path, file: Tsplib, own: float | None, whole: bool) -> float | None:
    """Return the least value that the comment or a solution beside the file knows."""
    beside, notes = reference_beside(path)
    file.notes.extend(notes)
    known = beside if own is None else [own, *beside]
    if whole and any(value.is_integer() for value in known):
        known = [value for value in known if value.is_integer()]
    least = min(known, default=None)
    if whole and least is not None and not least.is_integer():
        file.notes.append(
            f"the reference {least:g} is not whole, but distances are rounded to whole numbers "
            "(rounding none leaves them as they are)"
        )
    return least


@dataclass(frozen=True, slots=True)
class _Places:
    """Where things stand."""

    warehouse: Warehouse
    nodes: list[Place]
    whole: bool
    """Whether distances were rounded to whole numbers."""


def _places(
    file: Tsplib, size: int, depot: int, own: float | None, rounding: str | None
) -> _Places:
    kind = file.text("EDGE_WEIGHT_TYPE").upper()
    weights = file.sections.get("EDGE_WEIGHT")
    if not kind and weights is not None:
        kind = "EXPLICIT"
    if kind not in {*METRICS, "EXPLICIT", "GEO", "ATT"}:
        mend = f"use EXPLICIT, GEO, ATT, {', '.join(METRICS)}"
        field = file.fields.get("EDGE_WEIGHT_TYPE")
        if field is None:
            raise InputError("is missing", field="EDGE_WEIGHT_TYPE", mend=mend)
        raise field.error(f"{kind:.40} is not known", mend)
    if kind != "EXPLICIT" and weights is not None:
        raise weights.error(f"stands beside EDGE_WEIGHT_TYPE {kind}", "keep one of them")
    if rounding is not None and kind not in METRICS:
        raise InputError(
            f"EDGE_WEIGHT_TYPE {kind} leaves nothing to round",
            field="rounding",
            mend="leave it out",
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


def _in_table(matrix: Floats, depot: int, positions: Floats | None, *, whole: bool) -> _Places:
    drawn = None if positions is None else tuple((x, y) for x, y in positions[:, :2].tolist())
    table = DistanceTable(tuple(map(tuple, matrix.tolist())), depot, drawn)
    return _Places(table, [Node(i) for i in range(len(matrix))], whole)


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


def _on_floor(file: Tsplib, kind: str, depot: int, positions: Floats, asked: str | None) -> _Places:
    whole = asked != "none"
    if kind in ("EUC_2D", "MAN_2D") and asked in (None, "none", "nearest"):
        x, y = positions[depot].tolist()
        floor = OpenFloor(
            x,
            y,
            "euclidean" if kind == "EUC_2D" else "manhattan",
            "nearest" if whole else "none",
        )
        return _Places(floor, [Point(x, y) for x, y in positions.tolist()], whole)
    length, rounded = METRICS[kind]
    lengths = length(positions[:, None, :] - positions[None, :, :])
    matrix = (rounded if asked is None else ROUNDINGS[asked])(lengths)
    file.notes.extend(coarse(matrix, lengths, kind))
    return _in_table(matrix, depot, positions, whole=whole)


def _positions(file: Tsplib, size: int, kind: str) -> Floats:
    """Return the coordinates, shape (size, 2) or, for 3D kinds, (size, 3)."""
    solid = kind.endswith("_3D") or (
        kind == "EXPLICIT" and file.text("NODE_COORD_TYPE").upper() == "THREED_COORDS"
    )
    words, rows = _table(file, "NODE_COORD", size, 4 if solid else 3)
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
        raise InputError("is missing", field="EDGE_WEIGHT_SECTION", mend="add it")
    field = file.fields.get("EDGE_WEIGHT_FORMAT")
    mend = f"use one of {', '.join(LAYOUTS)}"
    if field is None:
        raise InputError("is missing", field="EDGE_WEIGHT_FORMAT", mend=mend)
    layout = field.value.upper()
    if layout not in LAYOUTS:
        raise field.error(f"{layout:.40} is not known", mend)
    return square_matrix(section, layout, size)


def _name(file: Tsplib) -> str:
    name = " ".join(file.text("NAME").split())[:200]
    if (hidden := first_invisible(name)) is not None:
        raise file.fields["NAME"].error(f"holds the invisible character {hidden}", "remove it")
    return name


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable())[:200].strip()
