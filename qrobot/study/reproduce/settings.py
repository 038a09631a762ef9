"""What a reproduction is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from qrobot.errors import InputError
from qrobot.study.reproduce.instances import SEED

__all__ = ["Settings"]

QUICK_ITEMS = 4


@dataclass(frozen=True, slots=True)
class Settings:
    """What is asked for.

    Parameters
    ----------
    reads
        Shots of every method and of its control.
    seed
        Of our places and of every random choice.
    rows
        Numbers of items, such as ``2-5`` or ``2,4,10-12``; ``None``: all.
    largest
        Most items; ``None``: 12.
    large
        Whether 26 qubits are simulated too (1.5 GiB).
    quick
        At most four items and no SDK.
    """

    reads: int = 1000
    seed: int = SEED
    rows: str | None = None
    largest: int | None = None
    large: bool = False
    quick: bool = False

    def items(self) -> list[int]:
        """Return the numbers of items that are wanted.

        Raises
        ------
        InputError
            When they are not 2 to 12, or other settings are out of range.
        """
        for name, value, least in (("reads", self.reads, 1), ("seed", self.seed, 0)):
            if value < least:
                raise InputError(
                    f"{value} is too small", field=f"--{name}", mend=f"give {least} or more"
                )
        wanted = _numbers(self.rows) if self.rows else set(range(2, 13))
        if self.largest is not None:
            wanted = {n for n in wanted if n <= self.largest}
        if self.quick:
            wanted = {n for n in wanted if n <= QUICK_ITEMS}
        if not wanted:
            raise InputError(
                "no row is left", field="--rows", mend="the tables have rows of 2 to 12 items"
            )
        return sorted(wanted)


def _numbers(text: str) -> set[int]:
    found: set[int] = set()
    for part in text.split(","):
        first, _, last = part.strip().partition("-")
        if not (first.isdecimal() and (last or first).isdecimal()):
            raise InputError(
                f"{text!r} names no rows", field="--rows", mend="write it like 2-5 or 2,4,10-12"
            )
        found |= set(range(int(first), int(last or first) + 1))
    if not found <= set(range(2, 13)):
        raise InputError(
            f"{text!r} goes beyond the tables", field="--rows", mend="give rows of 2 to 12 items"
        )
    return found
