"""Run the rows one by one, and keep each as soon as it is there."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from qrobot._files import read_text, write_text_atomic
from qrobot._json import json_text
from qrobot.errors import InputError, MissingExtraError, QRobotError
from qrobot.report.machine import machine
from qrobot.study.reproduce.faces import write_tables
from qrobot.study.reproduce.figures import FIGURES, draw_figure
from qrobot.study.reproduce.instances import PLACES
from qrobot.study.reproduce.left import Left
from qrobot.study.reproduce.methods import Method, methods_for
from qrobot.study.reproduce.outcome import Line
from qrobot.study.reproduce.paper import TITLE, YEAR, PaperRow, paper_rows
from qrobot.study.reproduce.question import Question
from qrobot.study.reproduce.settings import Settings

__all__ = ["SCHEMA", "TARGETS", "reproduce"]

SCHEMA = "qrobot.reproduce/1"
TABLES = {"table1": 1, "table2": 2, "table3": 3}
TARGETS = (*TABLES, *FIGURES)


def reproduce(
    targets: Sequence[str],
    output: str | os.PathLike[str],
    settings: Settings | None = None,
    *,
    resume: bool = False,
    on_start: Callable[[Line], None] | None = None,
    on_line: Callable[[Line], None] | None = None,
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
        raise InputError(f"{unknown[0]!r} is no target", mend=f"use one of {', '.join(TARGETS)}")
    wanted = settings.items()
    folder = Path(output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})",
            source=os.fspath(output),
            mend="choose another place",
        ) from None
    report: dict[str, Any] = {
        "schema": SCHEMA,
        "paper": {"title": TITLE, "year": YEAR},
        "places": PLACES.format(seed=settings.seed) + ".",
        "machine": machine(),
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "settings": asdict(settings),
        "targets": list(targets),
        "interrupted": False,
        "lines": [],
        "figures": [],
        "notes": [],
    }
    known = _finished(folder, report) if resume else []
    tables = [TABLES[name] for name in targets if name in TABLES]
    try:
        for line in _lines(tables, wanted, settings, known, on_start):
            report["lines"].append(asdict(line))
            _save(report, folder)
            if on_line is not None:
                on_line(line)
            if interrupted is not None and interrupted():
                raise KeyboardInterrupt
        for name in targets:
            if name not in FIGURES:
                continue
            try:
                made = draw_figure(name, folder, settings.seed)
            except MissingExtraError as error:
                if not tables:
                    raise
                report["notes"].append(f"{name} is left out: {error}")
                continue
            report["figures"].append(made)
            _save(report, folder)
            if on_figure is not None:
                on_figure(made)
    except KeyboardInterrupt:
        report["interrupted"] = True
    _save(report, folder, plots=True)
    return report


def _lines(
    tables: Sequence[int],
    wanted: Sequence[int],
    settings: Settings,
    known: list[Line],
    on_start: Callable[[Line], None] | None,
) -> Iterator[Line]:
    """Yield a line for each table, row and method; tables 2 and 3 share their runs."""
    # The reduced rows of tables 2 and 3 ask the same: one run, two faces.
    done = {_key(line): line for line in known}
    questions: dict[tuple[str, int], Question] = {}
    warmed: set[str] = set()
    for table in tables:
        for row in paper_rows(table):
            if row.items not in wanted:
                continue
            for method, reason in methods_for(row, large=settings.large, quick=settings.quick):
                line = _blank(row, method)
                if (found := done.get(_key(line))) is not None:
                    yield _again(found, row)
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
    method: Method, line: Line, question: Question, settings: Settings, warmed: set[str]
) -> Line:
    """Run a method; whatever happens becomes a line."""
    try:
        if method.backend not in warmed:
            method.warm()
            warmed.add(method.backend)
        return method.run(line, question, settings.reads, settings.seed)
    except (Left, MissingExtraError) as left:
        line.status, line.reason = "skipped", str(left)
    except QRobotError as error:
        line.status, line.reason = "failed", str(error)
    except Exception as error:
        # An SDK's own error: its kind only, for its text could hold anything.
        line.status, line.reason = "failed", f"{method.name} failed ({type(error).__name__})"
    return line


def _key(line: Line) -> tuple[str, int, str]:
    return ("full" if line.table == 1 else "reduced", line.items, line.method)


def _blank(row: PaperRow, method: Method) -> Line:
    return Line(
        table=row.table,
        items=row.items,
        robots=row.robots,
        capacity=row.capacity,
        qubits=row.qubits,
        method=method.name,
        backend=method.backend,
        paper_annealer_seconds=row.annealer,
        paper_ibmq_seconds=row.seconds.get("ibmq_qasm_simulator"),
        paper_pennylane_seconds=row.seconds.get("pennylane"),
    )


def _again(line: Line, row: PaperRow) -> Line:
    """Return a finished line as one of another table with the same question."""
    values = asdict(line) | {
        "table": row.table,
        "paper_annealer_seconds": row.annealer,
        "paper_ibmq_seconds": row.seconds.get("ibmq_qasm_simulator"),
        "paper_pennylane_seconds": row.seconds.get("pennylane"),
    }
    return Line(**values)


def _finished(folder: Path, report: dict[str, Any]) -> list[Line]:
    """Return the finished lines of an earlier run under the same settings."""
    path = folder / "reproduce.json"
    if not path.is_file():
        return []
    try:
        before = json.loads(read_text(path))
        same = all(before["settings"][name] == report["settings"][name] for name in _MATTERS)
        if same and before["schema"] == SCHEMA and before["machine"] == report["machine"]:
            return [Line(**line) for line in before["lines"] if line["status"] == "done"]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"is no report of ours ({type(error).__name__})",
            source=os.fspath(path),
            mend="choose another folder, or leave --resume out",
        ) from None
    raise InputError(
        "was made with other reads, another seed, version or machine",
        source=os.fspath(path),
        mend="choose another folder, or leave --resume out",
    )


_MATTERS = ("reads", "seed")


def _save(report: dict[str, Any], folder: Path, *, plots: bool = False) -> None:
    report["notes"] = list(dict.fromkeys([*report["notes"], *write_tables(report, folder, plots)]))
    write_text_atomic(folder / "reproduce.json", json_text(report, indent=1) + "\n")
