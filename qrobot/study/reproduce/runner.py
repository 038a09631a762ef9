"""Run the rows one by one, and keep each as soon as it is there."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from qrobot._files import read_text, write_text_atomic
from qrobot._json import json_text
from qrobot.errors import InputError, MissingExtraError, QRobotError
from qrobot.study.reproduce.figures import FIGURES, draw_figure
from qrobot.study.reproduce.methods import CannotRun, Method, methods_for
from qrobot.study.reproduce.paper import PLACES, SEED, TITLE, YEAR, PaperRow, paper_rows
from qrobot.study.reproduce.question import Outcome, Question
from qrobot.study.reproduce.tables import write_tables
from qrobot.study.runner import Part, measured_here, run_parts

__all__ = ["SCHEMA", "TARGETS", "Settings", "reproduce"]

SCHEMA = "qrobot.reproduce/1"
TABLES = {"table1": 1, "table2": 2, "table3": 3}
TARGETS = (*TABLES, *FIGURES)


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
                    f"{value} is too small", field=f"--{name}", advice=f"give {least} or more"
                )
        wanted = _numbers(self.rows) if self.rows else set(range(2, 13))
        if self.largest is not None:
            wanted = {n for n in wanted if n <= self.largest}
        if self.quick:
            wanted = {n for n in wanted if n <= QUICK_ITEMS}
        if not wanted:
            raise InputError(
                "no row is left", field="--rows", advice="the tables have rows of 2 to 12 items"
            )
        return sorted(wanted)


def _numbers(text: str) -> set[int]:
    found: set[int] = set()
    for part in text.split(","):
        first, _, last = part.strip().partition("-")
        if not (first.isdecimal() and (last or first).isdecimal()):
            raise InputError(
                f"{text!r} names no rows", field="--rows", advice="write it like 2-5 or 2,4,10-12"
            )
        found |= set(range(int(first), int(last or first) + 1))
    if not found <= set(range(2, 13)):
        raise InputError(
            f"{text!r} goes beyond the tables", field="--rows", advice="give rows of 2 to 12 items"
        )
    return found


def reproduce(
    targets: Sequence[str],
    output: str | os.PathLike[str],
    settings: Settings | None = None,
    *,
    resume: bool = False,
    on_start: Callable[[Outcome], None] | None = None,
    on_line: Callable[[Outcome], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
    on_figure: Callable[[dict[str, Any]], None] | None = None,
) -> dict[str, Any]:
    """Reproduce tables and figures of the paper into a folder, and return the report.

    ``reproduce.json`` and the tables are written anew after every line, each file as a whole,
    so that an interrupted run keeps what it has; Ctrl-C ends it, and the report says so.

    Parameters
    ----------
    targets
        Some of `TARGETS`.
    output
        A folder, made when it is missing.
    settings
        What is asked for.
    resume
        Take over what an earlier run in the folder finished, under the same settings and on
        the same machine.
    on_start, on_line, on_figure
        Told of a line that begins, and of each line and figure that is there.
    interrupted
        Asked after each line; True ends the run as Ctrl-C does.

    Raises
    ------
    InputError
        When a setting is out of range or the folder cannot be used.
    MissingExtraError
        When nothing but figures is wanted and matplotlib is not installed.
    """
    settings = settings or Settings()
    unknown = [name for name in targets if name not in TARGETS]
    if unknown:
        raise InputError(
            f"{unknown[0]!r} is not a target", advice=f"use one of {', '.join(TARGETS)}"
        )
    wanted = settings.items()
    folder = Path(output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})",
            source=os.fspath(output),
            advice="choose another place",
        ) from None
    report: dict[str, Any] = {
        "schema": SCHEMA,
        "paper": {"title": TITLE, "year": YEAR},
        "places": PLACES.format(seed=settings.seed) + ".",
        **measured_here(),
        "settings": asdict(settings),
        "targets": list(targets),
        "interrupted": False,
        "lines": [],
        "figures": [],
        "notes": [],
    }
    known = _finished(folder, report) if resume else []
    lines = _lines([n for n in targets if n in TABLES], wanted, settings, known, on_start)
    figures = _figures(targets, folder, settings.seed, report["notes"])
    run_parts(
        report,
        [Part("lines", lines, asdict, on_line), Part("figures", figures, dict, on_figure)],
        lambda: _save(report, folder),
        interrupted,
    )
    _save(report, folder, plots=True)
    return report


def _figures(
    targets: Sequence[str], folder: Path, seed: int, notes: list[str]
) -> Iterator[dict[str, Any]]:
    """Draw the figures; beside tables one that cannot be drawn is only noted."""
    for name in targets:
        if name in FIGURES:
            try:
                yield draw_figure(name, folder, seed)
            except MissingExtraError as error:
                if not TABLES.keys() & set(targets):
                    raise
                notes.append(f"{name} is left out: {error}")


def _lines(
    tables: Sequence[str],
    wanted: Sequence[int],
    settings: Settings,
    known: list[Outcome],
    on_start: Callable[[Outcome], None] | None,
) -> Iterator[Outcome]:
    """Yield a line for each table, row and method; tables 2 and 3 share their runs."""
    # The reduced rows of tables 2 and 3 ask the same: one run, shown twice.
    done = {_key(line): line for line in known}
    questions: dict[tuple[str, int], Question] = {}
    warmed: set[str] = set()
    for table in tables:
        for row in paper_rows(TABLES[table]):
            if row.items not in wanted:
                continue
            for method, reason in methods_for(row, large=settings.large, quick=settings.quick):
                line = _blank(row, method)
                if (found := done.get(_key(line))) is not None:
                    yield replace(found, **_printed(row))
                    continue
                asked = (row.encoding, row.items)
                if reason is None and asked not in questions:
                    questions[asked] = Question.of(row, settings.seed)
                if reason is not None:
                    line.status, line.reason = "skipped", reason
                else:
                    if on_start is not None:
                        on_start(line)
                    line = _run(method, line, questions[asked], settings, warmed)
                if line.status == "done":
                    done[_key(line)] = line
                yield line


def _run(
    method: Method, line: Outcome, question: Question, settings: Settings, warmed: set[str]
) -> Outcome:
    """Run a method; whatever happens becomes a line."""
    try:
        if method.backend not in warmed:
            method.warm()
            warmed.add(method.backend)
        return method.run(line, question, settings.reads, settings.seed)
    except (CannotRun, MissingExtraError) as left:
        line.status, line.reason = "skipped", str(left)
    except QRobotError as error:
        line.status, line.reason = "failed", str(error)
    except Exception as error:
        # An SDK's own error: its kind only, for its text could hold anything.
        line.status, line.reason = "failed", f"{method.name} failed ({type(error).__name__})"
    return line


def _key(line: Outcome) -> tuple[str, int, str]:
    return ("full" if line.table == 1 else "reduced", line.items, line.method)


def _blank(row: PaperRow, method: Method) -> Outcome:
    return Outcome(
        items=row.items,
        robots=row.robots,
        capacity=row.capacity,
        qubits=row.qubits,
        method=method.name,
        backend=method.backend,
        **_printed(row),
    )


def _printed(row: PaperRow) -> dict[str, Any]:
    """Return what a table prints for a row; tables 2 and 3 share the rest."""
    return {
        "table": row.table,
        "paper_annealer_seconds": row.annealer,
        "paper_ibmq_seconds": row.seconds.get("ibmq_qasm_simulator"),
        "paper_pennylane_seconds": row.seconds.get("pennylane"),
    }


def _finished(folder: Path, report: dict[str, Any]) -> list[Outcome]:
    """Return the finished lines of an earlier run under the same settings."""
    path = folder / "reproduce.json"
    if not path.is_file():
        return []
    try:
        before = json.loads(read_text(path))
        same = all(before["settings"][name] == report["settings"][name] for name in _MATTERS)
        if same and before["schema"] == SCHEMA and before["machine"] == report["machine"]:
            return [Outcome(**line) for line in before["lines"] if line["status"] == "done"]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"is not a report of ours ({type(error).__name__})",
            source=os.fspath(path),
            advice="choose another folder, or leave --resume out",
        ) from None
    raise InputError(
        "was made with other reads, another seed, version or machine",
        source=os.fspath(path),
        advice="choose another folder, or leave --resume out",
    )


_MATTERS = ("reads", "seed")


def _save(report: dict[str, Any], folder: Path, *, plots: bool = False) -> None:
    report["notes"][:] = list(
        dict.fromkeys([*report["notes"], *write_tables(report, folder, plots)])
    )
    write_text_atomic(folder / "reproduce.json", json_text(report, indent=1) + "\n")
