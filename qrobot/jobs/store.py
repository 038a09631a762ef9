"""The jobs on other people's machines, kept in one small SQLite file.

A job is written before it is submitted and again as soon as the service has named it, each
time flushed to the disk, so that a killed process or a lost supply costs no paid answer.
The file is for its owner's eyes (mode 0600) and holds no secret: all texts are masked.
"""

from __future__ import annotations

import builtins
import json
import os
import sqlite3
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from qrobot._json import json_text
from qrobot.errors import InputError
from qrobot.jobs.job import ENDED, STATES, Estimate, RemoteJob
from qrobot.jobs.redaction import redact, redact_data

__all__ = ["JobStore", "default_path"]

if TYPE_CHECKING:
    import dimod

VERSION = 1
"""Of the tables; kept in SQLite's user_version."""

BUSY_TIMEOUT = 30.0
"""Seconds to wait for other writers; a memory card takes a tenth of one for each change."""

LARGEST_ANSWER = 20_000_000
"""Bytes; larger answers are not kept here, but can be fetched from the service again."""

_TABLE = """
CREATE TABLE IF NOT EXISTS jobs (
    id TEXT PRIMARY KEY, remote_id TEXT NOT NULL, backend TEXT NOT NULL, device TEXT NOT NULL,
    state TEXT NOT NULL, submitted REAL NOT NULL, variables INTEGER NOT NULL,
    model BLOB NOT NULL, context TEXT NOT NULL, timings TEXT NOT NULL, estimate TEXT NOT NULL,
    problem TEXT NOT NULL, answer BLOB
) STRICT
"""
_COLUMNS = (
    "id", "remote_id", "backend", "device", "state", "submitted", "variables", "model", "context",
    "timings", "estimate", "problem",
)  # fmt: skip


def default_path() -> Path:
    """Return where the jobs are kept: ``$XDG_STATE_HOME/qrobot/jobs.sqlite3``."""
    home = os.environ.get("XDG_STATE_HOME")
    folder = Path(home) if home and Path(home).is_absolute() else Path.home() / ".local" / "state"
    return folder / "qrobot" / "jobs.sqlite3"


class JobStore:
    """The jobs of this user; several processes may use it at once.

    Parameters
    ----------
    path
        The file; made when it is absent. Default: `default_path`.

    Raises
    ------
    InputError
        When the file cannot be used.
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        self.path = Path(path) if path is not None else default_path()
        try:
            self.path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            # Made by us with its final mode: SQLite's own -wal and -shm take it over.
            os.close(os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600))
            if self.path.stat().st_mode & 0o077:
                self.path.chmod(0o600)
        except OSError as error:
            raise self._unusable(error.strerror or str(error)) from None
        with self._translated():
            self._db = sqlite3.connect(self.path, timeout=BUSY_TIMEOUT, isolation_level=None)
            try:
                self._prepare_in_turn()
            except BaseException:
                self._db.close()
                raise

    def _prepare_in_turn(self) -> None:
        """Prepare the file, and again while others prepare it.

        Two that switch a new file's journal at once would wait for each other; SQLite then refuses
        one of them at once, without waiting.
        """
        end = time.monotonic() + BUSY_TIMEOUT
        while True:
            try:
                self._prepare()
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or time.monotonic() > end:
                    raise
                time.sleep(0.05)
            else:
                return

    def _prepare(self) -> None:
        """Bring the file into this version's form, or refuse it."""
        self._db.execute("PRAGMA journal_mode=WAL")
        self._db.execute("PRAGMA synchronous=FULL")
        found = int(self._db.execute("PRAGMA user_version").fetchone()[0])
        if found > VERSION:
            raise InputError(
                f"was written by a newer qrobot (version {found})",
                source=str(self.path),
                advice="upgrade qrobot, or move the file away",
            )
        self._db.execute(_TABLE)
        if found != VERSION:
            self._db.execute(f"PRAGMA user_version={VERSION}")

    def _unusable(self, why: str) -> InputError:
        return InputError(
            f"cannot keep jobs in {str(self.path)!r}: {why}",
            advice="set XDG_STATE_HOME to a folder that can be written, or advice the file",
        )

    @contextmanager
    def _translated(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise self._unusable(str(error)) from None

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def __enter__(self) -> JobStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add(self, job: RemoteJob) -> RemoteJob:
        """Keep a new job; it is on the disk when this returns."""
        marks = ", ".join("?" * len(_COLUMNS))
        with self._translated():
            self._db.execute(
                f"INSERT INTO jobs ({', '.join(_COLUMNS)}) VALUES ({marks})",  # noqa: S608
                _row(job),
            )
        return job

    def update(self, job: RemoteJob) -> RemoteJob:
        """Keep what has changed of a job; it is on the disk when this returns."""
        sets = ", ".join(f"{name} = ?" for name in _COLUMNS)
        with self._translated():
            self._db.execute(
                f"UPDATE jobs SET {sets} WHERE id = ?",  # noqa: S608
                (*_row(job), job.id),
            )
        return job

    def keep_answer(self, job: RemoteJob, samples: dimod.SampleSet) -> None:
        """Keep the samples of a job, when they are not too many."""
        stored = samples.to_serializable()
        stored["info"] = redact_data(stored["info"])
        data = zlib.compress(json_text(stored).encode(), 6)
        if len(data) > LARGEST_ANSWER:
            return
        with self._translated():
            self._db.execute("UPDATE jobs SET answer = ? WHERE id = ?", (data, job.id))

    def answer(self, job: RemoteJob) -> dimod.SampleSet | None:
        """Return the kept samples of a job, or ``None``."""
        import dimod

        with self._translated():
            row = self._db.execute("SELECT answer FROM jobs WHERE id = ?", (job.id,)).fetchone()
        if row is None or row[0] is None:
            return None
        return dimod.SampleSet.from_serializable(json.loads(zlib.decompress(row[0])))

    def list(
        self, state: str | None = None, backend: str | None = None, limit: int = 1000
    ) -> list[RemoteJob]:
        """Return jobs, the newest first.

        Raises
        ------
        InputError
            When there is no such state.
        """
        if state is not None and state not in STATES:
            raise InputError(
                f"{state!r} is not a state",
                field="state",
                advice=f"use one of: {', '.join(STATES)}",
            )
        return self._select(
            "(?1 IS NULL OR state = ?1) AND (?2 IS NULL OR backend = ?2)"
            " ORDER BY submitted DESC, rowid DESC LIMIT ?3",
            (state, backend, limit),
        )

    def get(self, name: str) -> RemoteJob:
        """Return a job by our name, the service's name, or an unmistakable beginning of ours.

        Raises
        ------
        InputError
            When no job, or more than one, has that name.
        """
        jobs = self._select(
            "id = ?1 OR (remote_id = ?1 AND ?1 <> '')"
            " OR (length(?1) >= 4 AND substr(id, 1, length(?1)) = ?1) LIMIT 2",
            (name,),
        )
        if len(jobs) != 1:
            found = "no job is" if not jobs else "more than one job is"
            raise InputError(
                f"{found} named {redact(name)!r}", field="job", advice="see 'qrobot jobs list'"
            )
        return jobs[0]

    def _select(self, condition: str, parameters: tuple[Any, ...]) -> builtins.list[RemoteJob]:
        query = f"SELECT {', '.join(_COLUMNS)} FROM jobs WHERE {condition}"  # noqa: S608
        with self._translated():
            return [_job(row) for row in self._db.execute(query, parameters).fetchall()]

    def prune(self, days: float = 30.0) -> int:
        """Forget jobs that ended and are older than so many days; return how many.

        Jobs that may still run are kept, whatever their age.
        """
        before = time.time() - days * 86400
        ended = ", ".join(f"'{state}'" for state in sorted(ENDED))
        with self._translated():
            gone = self._db.execute(
                f"DELETE FROM jobs WHERE submitted < ? AND state IN ({ended})",  # noqa: S608
                (before,),
            )
        return gone.rowcount


def _row(job: RemoteJob) -> tuple[Any, ...]:
    return (
        job.id, redact(job.remote_id, guess=False), job.backend,
        redact(job.device, guess=False), job.state, job.submitted,
        job.variables, job.model, json_text(_context(job)), json_text(job.timings),
        json_text(redact_data(job.estimate.to_dict())), redact(job.problem),
    )  # fmt: skip


def _context(job: RemoteJob) -> dict[str, Any]:
    """Return what is kept beside a job, without secrets and without guessing at the instance.

    An item may well be called ``token 2024box``: masking it would make the plan a wrong one.
    """
    kept = dict(job.context)
    instance = kept.pop("instance", None)
    masked: dict[str, Any] = redact_data(kept)
    if isinstance(instance, str):
        masked["instance"] = redact(instance, guess=False)
    return masked


def _job(row: tuple[Any, ...]) -> RemoteJob:
    data = dict(zip(_COLUMNS, row, strict=True))
    for name in ("context", "timings", "estimate"):
        data[name] = json.loads(data[name])
    return RemoteJob(**data | {"estimate": Estimate(**data["estimate"])})
