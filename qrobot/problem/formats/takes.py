"""What the lines of orders take from which bins, where articles lie in several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from qrobot.problem import Stock
from qrobot.problem.formats.cells import Line
from qrobot.problem.formats.masters import Bin, Masters, has_place, name_of

__all__ = ["Take", "takes_of"]


@dataclass(frozen=True, slots=True)
class Take:
    """Pieces that a line takes from one bin."""

    line: Line
    bin: Bin
    pieces: int


def takes_of(lines: Sequence[Line], masters: Masters) -> tuple[list[Take], tuple[Stock, ...]]:
    """Return what is taken from where, line by line, and the stock of what is asked for.

    A line that names its bin is a first choice that keeps its pieces there; the others take those
    that are left, from the bins in the sequence of the article master. Planners that know a stock
    choose anew.
    """
    asked = dict.fromkeys(map(name_of, lines))
    there = {name: stock for name in asked if (stock := masters.stock(name))}
    left = {name: dict(stock) for name, stock in there.items()}
    own: dict[int, Bin] = {}
    for k, line in enumerate(lines):
        bins = left.get(name_of(line))
        if bins is None or has_place(line):
            own[k] = masters.bin(line)
        if bins is not None and k in own:
            _keep(line, own[k], bins)
    takes: list[Take] = []
    for k, line in enumerate(lines):
        if k in own:
            takes.append(Take(line, own[k], _pieces(line)))
        else:
            takes += _shared(line, left[name_of(line)])
    stocks = tuple(
        Stock(name, one.place, pieces, one.level, one.label)
        for name, bins in there.items()
        for one, pieces in bins.items()
        if pieces
    )
    return takes, stocks


def _pieces(line: Line) -> int:
    return line.whole("quantity", least=1) if line.has("quantity") else 1


def _keep(line: Line, own: Bin, left: dict[Bin, int]) -> None:
    """Take the pieces of a line out of the bin that it names."""
    wanted, there = _pieces(line), left.get(own, 0)
    if wanted > there:
        raise line.error(
            "place",
            f"{wanted} pieces of article {name_of(line)!r:.60} are asked for in "
            f"{own.label or own.place}, and {there} are left there",
            "ask for fewer, leave the place out, or correct the stock in the article master",
        )
    left[own] = there - wanted


def _shared(line: Line, left: dict[Bin, int]) -> list[Take]:
    """Return what a line takes from what is left, and take it away."""
    wanted, found = _pieces(line), []
    if wanted > sum(left.values()):
        raise line.error(
            "quantity",
            f"{wanted} pieces of article {name_of(line)!r:.60} are asked for, and "
            f"{sum(left.values())} are left in stock",
            "ask for fewer, or correct the stock in the article master",
        )
    for one, pieces in left.items():
        if took := min(pieces, wanted):
            found.append(Take(line, one, took))
            left[one] -= took
            wanted -= took
    return found
