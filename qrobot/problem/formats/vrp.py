"""CVRPLIB and QOBLIB files: ``.vrp`` instances, in the words of TSPLIB 95.

What a file says is read or refused: a field or section that changes the question, such as a
limit of the trips' length, is never passed over, and one that nobody knows might. The number
of vehicles, which has no field of its own, is taken from the comment or the name.

What the comment and ``.sol`` files beside it know of the least distance is only for comparison:
the question is the same whatever stands there. What is not a finite number above zero is passed
over, and a note says so.
"""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import (
    MAX_ITEMS,
    MAX_STOPS,
    Instance,
    Item,
    Order,
    Robot,
)
from qrobot.problem.checks import first_invisible, is_reference
from qrobot.problem.formats.registry import ReadOptions, builtin, checked
from qrobot.problem.formats.tsplib import Tsplib, parse
from qrobot.problem.formats.vrp_places import ROUNDINGS, places_of
from qrobot.problem.units import NUMBER, exact

__all__ = ["FORMAT", "read_solution", "read_vrp"]

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

_BEST = re.compile(
    r"\b(?:optimal|optimum|best(?:[ -]known)?)\s*(?:value|cost|solution|distance)?\s*[:=]\s*"
    r"([-+\w][-+\w.,'’]*)",
    re.IGNORECASE,
)
_ENDINGS = (".opt.sol", ".sol", ".bst.sol")


def read_vrp(path: Path, options: ReadOptions) -> Instance:
    """Return the instance of a CVRP or ACVRP with distances that TSPLIB 95 knows.

    Items are named ``1`` to ``n``, the clients' numbers in ``.sol`` files: the nodes in
    their sequence without the depot. The capacity and the rounding that are asked for take the
    place of CAPACITY and of what EDGE_WEIGHT_TYPE demands.
    """
    rounding = options.rounding
    if rounding is not None and rounding not in ROUNDINGS:
        raise InputError(
            f"{rounding!r:.40} is not a rounding",
            field="rounding",
            advice=f"use one of {', '.join(ROUNDINGS)}",
        )
    file = parse(read_text(path, fallback="latin-1"))
    _check_known(file)
    size = _whole(file, "DIMENSION", most=MAX_STOPS + 1)
    demands, rows = _demands(file, size)
    depot = _depot(file, size)
    if demands[depot]:
        raise file.sections["DEMAND"].error(
            f"the depot has demand {float(demands[depot]):.12g}", "make it 0", rows[depot], 1
        )
    own, notes = reference_in_comment(file.text("COMMENT"))
    file.notes.extend(notes)
    places = places_of(file, size, depot, own, rounding)
    clients = [node for node in range(size) if node != depot]
    items = tuple(
        Item(str(i + 1), demands[node], places.nodes[node]) for i, node in enumerate(clients)
    )
    count = 1 if options.robots_follow else _count(path, file)
    load = _capacity(file) if options.capacity is None else options.capacity

    def make() -> Instance:
        return Instance(
            warehouse=places.warehouse,
            items=items,
            orders=tuple(Order(item.id, (item.id,)) for item in items),
            robots=tuple(Robot(f"R{k + 1}", load) for k in range(count)),
            name=_name(file) or path.stem,
            comment=_printable(file.text("COMMENT")),
            reference=_reference(path, file, own, places.rounded),
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
        raise InputError("is missing", field=name, advice="add it; the file may be cut off")
    field = file.fields[name]
    digits = re.fullmatch(r"[0-9]{1,12}", field.value)
    if digits is None or not 1 <= int(field.value) <= most:
        large = digits is not None and int(field.value) > most
        raise field.error(
            f"{field.value:.40} is not a whole number from 1 to {most}",
            "plan in waves" if large else "correct it",
        )
    return int(field.value)


def _demands(file: Tsplib, size: int) -> tuple[list[Fraction], list[int]]:
    words, rows = file.nodes("DEMAND", size, 2)
    demands = []
    for (_, word), row in zip(words, rows, strict=True):
        try:
            demand = exact(word, field="")
        except InputError as error:
            raise error.at(file.sections["DEMAND"].where(row, 1)) from None
        if demand < 0:
            raise file.sections["DEMAND"].error(
                f"the demand {word:.40} is negative", "use zero or more", row, 1
            )
        demands.append(demand)
    return demands, rows


def _depot(file: Tsplib, size: int) -> int:
    advice = "give one node, then -1"
    if "DEPOT" not in file.sections:
        raise InputError("is missing", field="DEPOT_SECTION", advice=advice)
    section = file.sections["DEPOT"]
    numbers = section.stream().tolist()
    depots = numbers[: numbers.index(-1.0)] if -1.0 in numbers else numbers
    if not depots:
        raise section.error("names no depot", advice)
    if len(depots) > 1:
        raise section.error(f"{len(depots)} depots where one belongs", advice)
    if len(numbers) > 2:
        raise section.error_at(2, "a number stands behind -1", advice)
    if depots[0] not in range(1, size + 1):
        raise section.error_at(0, f"{depots[0]:.12g} is not a node", f"use 1 to {size}")
    return int(depots[0]) - 1


def _capacity(file: Tsplib) -> Fraction:
    if "CAPACITY" not in file.fields:
        raise InputError("is missing", field="CAPACITY", advice="add it, or give --capacity")
    field = file.fields["CAPACITY"]
    try:
        capacity = exact(field.value, field="")
    except InputError as error:
        raise error.at(field.where) from None
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
        advice="give the number of robots (--robots N, or --robots free)",
    )


def _reference(path: Path, file: Tsplib, own: float | None, rounded: bool) -> float | None:
    """Return the least value that the comment or a solution beside the file knows."""
    beside, notes = reference_beside(path)
    file.notes.extend(notes)
    known = beside if own is None else [own, *beside]
    if rounded and any(value.is_integer() for value in known):
        known = [value for value in known if value.is_integer()]
    least = min(known, default=None)
    if rounded and least is not None and not least.is_integer():
        file.notes.append(
            f"the reference {least:.12g} is not whole, but distances are rounded to whole numbers "
            "(rounding none leaves them as they are)"
        )
    return least


def _name(file: Tsplib) -> str:
    name = " ".join(file.text("NAME").split())[:200]
    if (hidden := first_invisible(name)) is not None:
        raise file.fields["NAME"].error(f"holds the invisible character {hidden}", "remove it")
    return name


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable())[:200].strip()


def read_solution(path: StrPath) -> tuple[list[list[int]], float]:
    """Return the routes of a ``.sol`` file, as numbers of clients, and its cost."""
    try:
        return _solution(read_text(path, fallback="latin-1"))
    except InputError as error:
        raise error.in_file(str(path)) from None


def _solution(text: str) -> tuple[list[list[int]], float]:
    routes: list[list[int]] = []
    cost: float | None = None
    for number, line in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
        if re.match(r"\s*route\b", line, re.IGNORECASE):
            _, colon, clients = line.partition(":")
            if not colon or not re.fullmatch(r"(?:\s*[0-9]{1,9})*\s*", clients):
                raise InputError(
                    "is not a solution",
                    field=f"line {number}",
                    advice="give lines such as 'Route #1: 3 1 2'",
                )
            routes.append([int(word) for word in clients.split()])
        elif found := re.match(r"\s*cost\b\s*[:=]?\s*(\S+)", line, re.IGNORECASE):
            cost = _positive(found[1])
            if cost is None:
                raise InputError(
                    f"{found[1]!r:.40} is not a number above zero",
                    field=f"Cost, line {number}",
                    advice="correct it",
                )
    if not routes or cost is None:
        missing = "Cost" if routes else "Route"
        raise InputError("is missing", field=missing, advice="give routes and cost")
    return routes, cost


def _positive(text: str) -> float | None:
    """Return a number that a gap can be told against, None for anything else."""
    value = float(text) if NUMBER.fullmatch(text) else 0.0
    return value if is_reference(value) else None


def reference_in_comment(comment: str) -> tuple[float | None, tuple[str, ...]]:
    """Return the value that a comment knows, as in "Optimal value: 784", and notes.

    A comment that is nothing but a number is the value (sets CMT and Golden).
    """
    found = _BEST.search(comment)
    text = found[1].rstrip(".,'’") if found else comment.strip(" \t\"'()")
    value = _positive(text)
    if found is None or value is not None:
        return value, ()
    if not re.search(r"\d", text) and not re.fullmatch(r"[-+]?(nan|inf\w*)", text, re.IGNORECASE):
        return None, ()  # a word, such as "unknown"
    return None, (
        f"the value {text!r:.40} in the comment is not a number above zero, so it is not taken "
        "as a reference",
    )


def reference_beside(path: Path) -> tuple[list[float], tuple[str, ...]]:
    """Return the costs of the solutions beside a ``.vrp`` file, and notes."""
    known, notes = [], []
    for ending in _ENDINGS:
        beside = path.with_name(path.stem + ending)
        if beside.is_file():
            try:
                known.append(read_solution(beside)[1])
            except InputError as error:
                where = f"{error.field}: " if error.field else ""
                notes.append(f"{beside.name} is passed over ({where}{error.problem})")
    return known, tuple(notes)


FORMAT = builtin(__name__, read_vrp)
