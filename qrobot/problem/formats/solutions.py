"""``.sol`` files and what is known of the least distance of a ``.vrp`` file.

A reference is only for comparison: the question is the same whatever stands here. What is
not a finite number above zero is passed over, and a note says so.
"""

from __future__ import annotations

import re
from pathlib import Path

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem.checks import is_reference
from qrobot.problem.units import NUMBER

__all__ = ["read_solution", "reference_beside", "reference_in_comment"]

_BEST = re.compile(
    r"\b(?:optimal|optimum|best(?:[ -]known)?)\s*(?:value|cost|solution|distance)?\s*[:=]\s*"
    r"([-+\w][-+\w.,'’]*)",
    re.IGNORECASE,
)
_ENDINGS = (".opt.sol", ".sol", ".bst.sol")


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
