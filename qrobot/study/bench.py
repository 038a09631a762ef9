"""Compare backends on a folder of instances, each run in a process of its own."""

from __future__ import annotations

import fnmatch
import json
import os
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from qrobot._files import write_text_atomic
from qrobot._formats import is_beside
from qrobot._json import json_text
from qrobot._processes import child_environment, python_command
from qrobot.errors import InputError
from qrobot.plan.objective import DISTANCE
from qrobot.problem.formats.registry import format_of, formats_of, suffixes
from qrobot.study.references import reference_of
from qrobot.study.runner import Part, measured_here, run_parts

__all__ = ["BENCH_SCHEMA", "BenchRow", "Task", "find_instances", "run_bench", "tasks"]

BENCH_SCHEMA = "qrobot.bench/1"
GRACE = 60.0
"""Seconds over the deadline after which a run counts as hung and is ended."""


@dataclass(frozen=True, slots=True)
class Task:
    """One run: an instance, a backend, a seed."""

    path: str
    backend: str
    seed: int
    deadline: float | None
    max_work: int | None = None
    robots: int | str | None = None
    reference: float | None = None
    rounding: str | None = None
    objective: str = "distance"
    name: str = ""
    """Of the instance, as rows show it; empty: its file's."""
    reference_status: str | None = None
    variant: str | None = None


@dataclass(slots=True)
class BenchRow:
    """What one run gave.

    Parameters
    ----------
    instance, backend, seed
        Which run.
    reference_status
        ``optimal`` or ``best known``, where an index says it of the reference.
    cost, bound, reference
        By the objective; ``None`` where there is none. References are distances.
    gap
        cost / reference - 1, or ``None``.
    proven, feasible
        Whether optimality was proven, and whether there is a plan.
    seconds
        `solve`'s own time: imports, reading and the checker's file work are not in it.
    wall_seconds
        The whole process, imports included.
    peak_mb
        Largest resident memory of the process, 10^6 bytes.
    trips, robots
        Trips of the plan, and robots that make them.
    error
        Why there is no plan.
    """

    instance: str
    backend: str
    seed: int
    cost: float | None = None
    bound: float | None = None
    reference: float | None = None
    gap: float | None = None
    proven: bool = False
    feasible: bool = False
    seconds: float | None = None
    wall_seconds: float | None = None
    peak_mb: float | None = None
    trips: int | None = None
    robots: int | None = None
    sampler: dict[str, Any] | None = None
    error: str | None = field(default=None)
    reference_status: str | None = None


def find_instances(folder: str | os.PathLike[str], match: str = "*") -> list[Path]:
    """Return the instance files of a folder and of those inside it, by path.

    Parameters
    ----------
    folder
        Where to look. What is hidden is passed over.
    match
        A pattern of the names, or of the paths from the folder; without ``*``, ``?`` or ``[``
        their beginning.

    Raises
    ------
    InputError
        When the folder is missing or holds none.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(
            "is not a folder", source=os.fspath(folder), advice="give a folder of instances"
        )
    pattern = match if any(c in match for c in "*?[") else f"{match}*"
    known = suffixes()
    found = sorted(
        path
        for path in _files_in(root)
        if path.suffix.lower() in known
        and path.name != "index.json"
        and not is_beside(path.name)
        and not path.name.endswith(".schema.json")
        and any(
            fnmatch.fnmatch(name, pattern)
            for name in (path.name, path.relative_to(root).as_posix())
        )
        and _is_instance(path)
    )
    if not found:
        raise InputError(
            f"holds no {', '.join(suffixes())} file like {match!r}",
            source=os.fspath(folder),
            advice="give another folder or pattern",
        )
    return found


def _files_in(root: Path) -> Iterator[Path]:
    for folder, folders, names in os.walk(root):
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (Path(folder, name) for name in names)


def _is_instance(path: Path) -> bool:
    """Return whether a file is not a text of another kind, nor a plan or report that we wrote."""
    try:
        if path.suffix != ".json":
            return format_of(path) is not None
        with path.open("rb") as file:
            start = file.read(200)
    except (OSError, InputError):
        return True  # reading the instance will tell why
    return not (b'"qrobot.plan/' in start or b'"qrobot.bench/' in start)


def tasks(
    paths: Sequence[Path],
    backends: Sequence[str],
    seeds: int,
    *,
    deadline: float | None,
    max_work: int | None = None,
    robots: int | str | None = None,
    robots_for: Sequence[str] = (),
    rounding: str | None = None,
    objective: str = "distance",
    root: Path | None = None,
    variant: str | None = None,
) -> list[Task]:
    """Return every run: instances x backends x seeds.

    Parameters
    ----------
    paths, backends, seeds
        What to run, with seeds 0, 1, ...
    deadline, max_work
        Limits of each run.
    robots
        Another number of robots, or ``free``, for all instances.
    robots_for
        Exceptions as ``PATTERN=N`` or ``PATTERN=free``; the first that matches counts.
    rounding
        Of the distances of the ``.vrp`` files, as of `read`.
    objective
        What shall be small, by name; the known values of files are distances, so there are no
        gaps for another one.
    root
        The folder of the comparison: rows name files in its folders by their path.
    variant
        Change the instances as a variant demands, and leave out those that no index has a
        value of it for.
    """
    rules = [_rule(text) for text in robots_for]
    found = []
    for path in paths:
        own = next((n for pattern, n in rules if fnmatch.fnmatch(path.name, pattern)), robots)
        known = reference_of(path, root or path.parent, variant)
        if variant is not None and known is None:
            continue
        value, status = known if known and objective == DISTANCE.name else (None, None)
        inside = path.relative_to(root) if root else Path(path.name)
        rounds = any("rounding" in format_.options for format_ in formats_of(path.suffix.lower()))
        task = Task(
            path=os.fspath(path),
            backend="",
            seed=0,
            deadline=deadline,
            max_work=max_work,
            robots=own,
            reference=value,
            rounding=rounding if rounds else None,
            objective=objective,
            name=inside.with_suffix("").as_posix() + (f" {variant}" if variant else ""),
            reference_status=status,
            variant=variant,
        )
        found += [replace(task, backend=b, seed=seed) for b in backends for seed in range(seeds)]
    return found


def _rule(text: str) -> tuple[str, int | str]:
    pattern, _, number = text.partition("=")
    if pattern and number.lower() == "free":
        return pattern, "free"
    if pattern and number.isascii() and number.isdigit() and int(number) > 0:
        return pattern, int(number)
    raise InputError(
        f"{text!r} is not a rule",
        field="--robots-for",
        advice="write it like 'X-*=free' or 'A-*=5'",
    )


def run_bench(
    todo: Sequence[Task],
    *,
    save: str | os.PathLike[str] | None = None,
    on_row: Callable[[int, BenchRow], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> dict[str, Any]:
    """Run all tasks, one after the other, and return the report.

    Ctrl-C ends the running task; the report then holds the finished ones and says so.

    Parameters
    ----------
    todo
        The runs.
    save
        Where to write the report as JSON; written anew after every run, so that an
        interrupted comparison keeps what it has.
    on_row
        Told the number of rows and the latest one.
    interrupted
        Asked after each row; True ends the comparison as Ctrl-C does.
    """
    report: dict[str, Any] = {
        "schema": BENCH_SCHEMA,
        **measured_here(),
        "objective": todo[0].objective if todo else DISTANCE.name,
        "runs": len(todo),
        "interrupted": False,
        "rows": [],
    }

    def keep() -> None:
        if save is not None:
            write_text_atomic(save, json_text(report, indent=1) + "\n")

    def tell(row: BenchRow) -> None:
        if on_row is not None:
            on_row(len(report["rows"]), row)

    run_parts(report, [Part("rows", _rows(todo), asdict, tell)], keep, interrupted)
    return report


def _rows(todo: Sequence[Task]) -> Iterator[BenchRow]:
    for task in todo:
        row = BenchRow(
            task.name or Path(task.path).stem,
            task.backend,
            task.seed,
            reference=task.reference,
            reference_status=task.reference_status,
        )
        limit = None if task.deadline is None else task.deadline + GRACE
        begun = time.perf_counter()
        try:
            done = subprocess.run(
                python_command("qrobot.study.bench_worker", json_text(asdict(task))),
                env=child_environment(),
                capture_output=True,
                encoding="utf-8",
                errors="replace",
                timeout=limit,
                check=False,
                start_new_session=True,  # Ctrl-C is for us: a run cut short has no row
            )
        except subprocess.TimeoutExpired:
            row.error = f"did not end within {limit:g} s"
        else:
            _take(row, done)
        row.wall_seconds = time.perf_counter() - begun
        if row.cost is not None and row.reference:
            row.gap = row.cost / row.reference - 1
        yield row


def _take(row: BenchRow, done: subprocess.CompletedProcess[str]) -> None:
    """Fill a row from what the worker printed, or from how it ended."""
    try:
        values = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        row.error = f"the process ended with code {done.returncode}: {last}"
        return
    for name, value in values.items():
        if name != "reference" or row.reference is None:
            setattr(row, name, value)
