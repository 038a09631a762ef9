"""What the notebooks of `healthchecks/` show: tables, small pictures and the verdict.

In a notebook they are displayed, in a plain script printed.
"""

from __future__ import annotations

import importlib
import io
import itertools
import math
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from qrobot._text import columns
from qrobot.health.check import Check, difference
from qrobot.pages import render

__all__ = ["VERDICT", "draw", "table", "verdict"]

VERDICT = "application/vnd.qrobot.verdict+json"
"""The kind of output that holds a verdict's numbers for a program, as text (nan has no JSON)."""


class Table:
    """Rows under heads; numbers stand on the right, six digits of them."""

    def __init__(self, heads: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        self.heads = list(heads)
        self.rows = [[_text(cell) for cell in row] for row in rows]
        self.numbers = frozenset(
            k for k in range(len(heads)) if rows and all(_is_number(row[k]) for row in rows)
        )

    def __str__(self) -> str:
        return columns(self.heads, self.rows, self.numbers, ruled=False)

    __repr__ = __str__  # what a terminal shows of an executed notebook

    def _repr_html_(self, words: str = "", color: str = "") -> str:
        """Return the table, and words below it."""
        template = Path(__file__).with_name("lesson.html")
        return render(template, table=self, words=words, color=color)


class _Verdict:
    """An answer beside the expected one, and what comes of it."""

    def __init__(
        self,
        check: Check,
        answer: Sequence[float],
        expected: Sequence[float],
        labels: Sequence[str],
        seconds: float,
    ) -> None:
        self.wrong = difference(answer, expected, check.tolerance)
        names = itertools.chain(labels, (f"number {k}" for k in itertools.count(len(labels) + 1)))
        rows = [
            (next(names), got, wanted, f"{abs(got - wanted):.1e}")
            for got, wanted in itertools.zip_longest(answer, expected, fillvalue=math.nan)
        ]
        self.table = Table(["", "answer", "expected", "difference"], rows)
        how = f"{check.name}, {seconds:.2f} s, expected from: {check.source}"
        self.words = (
            f"WRONG: {self.wrong} ({how})"
            if self.wrong
            else f"PASS: every difference is within {check.tolerance:g} ({how})"
        )
        self.data = {
            "check": check.name,
            "answer": [repr(number) for number in answer],
            "expected": [repr(number) for number in expected],
            "run_seconds": seconds,
        }

    def __str__(self) -> str:
        return f"{self.table}\n{self.words}"

    def _repr_mimebundle_(self, **_: object) -> dict[str, object]:
        color = "#b00020" if self.wrong else "#1b6e2f"
        return {
            "text/plain": str(self),
            "text/html": self.table._repr_html_(self.words, color),
            VERDICT: self.data,
        }


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Show a table: a head for every column, and the rows."""
    _show(Table(heads, rows))


def draw(picture: Callable[[Any], object], *, size: tuple[float, float] = (5.0, 2.2)) -> None:
    """Show a small picture, where matplotlib is installed.

    Parameters
    ----------
    picture
        Draws on the matplotlib axes that it is given.
    size
        Width and height in inches.
    """
    try:
        figures: Any = importlib.import_module("matplotlib.figure")
    except ImportError:
        print("(with matplotlib there would be a picture here)")  # noqa: T201
        return
    figure = figures.Figure(figsize=size, layout="constrained")
    picture(figure.add_subplot())
    if _display() is None:
        print("(a notebook shows a picture here)")  # noqa: T201
        return
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=100)
    _show(importlib.import_module("IPython.display").Image(data.getvalue()))


def verdict(check: Check, labels: Sequence[str] = ()) -> None:
    """Let the stack compute, show its answer beside the expected one, and judge.

    These are the check's own functions, the same that ``qrobot health`` runs.

    Parameters
    ----------
    labels
        Names of the first numbers of the answer.

    Raises
    ------
    AssertionError
        When the answer is wrong: the notebook has failed.
    """
    begun = time.perf_counter()
    answer = check.answer()
    seconds = time.perf_counter() - begun
    expected = check.expected()
    found = _Verdict(check, answer, expected, labels, seconds)
    _show(found)
    if found.wrong:
        raise AssertionError(found.wrong)


def _show(thing: object) -> None:
    display = _display()
    if display is None:
        print(thing)  # noqa: T201
    else:
        display(thing)


def _display() -> Any:
    """Return what displays in a notebook, None in a plain script."""
    ipython: Any = sys.modules.get("IPython")  # a notebook has imported it
    if ipython is None or ipython.get_ipython() is None:
        return None
    return importlib.import_module("IPython.display").display


def _is_number(cell: object) -> bool:
    return isinstance(cell, int | float)


def _text(cell: object) -> str:
    return f"{cell:.6g}" if isinstance(cell, float) else str(cell)
