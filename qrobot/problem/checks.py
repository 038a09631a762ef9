"""The checks that every number and every name passes, however it was made.

Names that look the same are the same: one program writes a letter and its accent as one
character, another as two. Characters that cannot be seen, or that turn the direction of writing,
would let two names look alike that are not.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

from qrobot.errors import InputError

__all__ = [
    "MAX_LENGTH",
    "canonical",
    "check_coordinate",
    "check_count",
    "check_direction",
    "check_index",
    "check_length",
    "check_reference",
    "first_invisible",
    "is_reference",
]

MAX_LENGTH = 1e9
"""No length or coordinate is larger, so that no sum of them overflows or loses a metre."""


def check_count(value: int, field: str, *, most: int) -> None:
    """Raise `InputError` when a count is not 1 to `most`."""
    if not 1 <= value <= most:
        raise InputError(f"{value} is not 1 to {most}", field=field, advice="correct the layout")


def check_index(value: int, field: str, *, count: int) -> None:
    """Raise `InputError` when something that is counted from 0 does not exist."""
    if not 0 <= value < count:
        raise InputError(
            f"{value} is outside the layout",
            field=field,
            advice=f"use 0 to {count - 1}" if count else "remove it",
        )


def check_direction(
    where: str, field: str, towards: str, known: Sequence[str], closed: bool, both: bool
) -> None:
    """Raise `InputError` when a one-way part leads nowhere, both ways, or is closed.

    Parameters
    ----------
    where, field
        The part, and its path in a document.
    towards, known
        Where it leads, and where such a part may lead.
    closed, both
        Whether it is closed, and whether it has both directions.
    """
    if towards not in known:
        raise InputError(
            f"{towards!r} is not a direction",
            field=f"{field}.towards",
            advice=f"use {' or '.join(known)}",
        )
    if closed:
        raise InputError(
            f"{where} is closed and has a direction",
            field=field,
            advice="open it, or leave its direction out",
        )
    if both:
        raise InputError(
            f"{where} is one-way in both directions", field=field, advice="keep one, or neither"
        )


def check_length(value: float, field: str, *, least: float = 0.0, most: float = MAX_LENGTH) -> None:
    """Raise `InputError` when a length, metres, is not finite or out of its bounds."""
    if not least <= value <= most:  # NaN too
        raise InputError(
            f"{value:g} is not {least:g} to {most:g}", field=field, advice="correct it (metres)"
        )


def check_coordinate(value: float, field: str) -> None:
    """Raise `InputError` when a coordinate, metres, is not finite or huge."""
    check_length(value, field, least=-MAX_LENGTH)


MIN_REFERENCE, MAX_REFERENCE = 1e-9, 1e15
"""Known least distances that a gap can be told against."""


def is_reference(value: float) -> bool:
    """Return whether a gap can be told against a known least distance."""
    return MIN_REFERENCE <= value <= MAX_REFERENCE  # no NaN either


def check_reference(value: float) -> None:
    """Raise `InputError` when a known least distance is of no use.

    It may be 0, where all that is collected lies at the depot.
    """
    if value != 0:
        check_length(value, "reference", least=MIN_REFERENCE, most=MAX_REFERENCE)


def canonical(name: str) -> str:
    """Return a name in normal form C, every kind of space as a plain one."""
    if name.isascii():
        return name
    name = unicodedata.normalize("NFC", name)
    return "".join(" " if unicodedata.category(c) == "Zs" else c for c in name)


def first_invisible(name: str) -> str | None:
    """Return the code of the first character that cannot be printed, such as ``U+200B``."""
    if name.isprintable():
        return None
    return next((f"U+{ord(c):04X}" for c in canonical(name) if not c.isprintable()), None)
