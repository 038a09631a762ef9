"""The folder of waves: an instance and a plan each, so that an interrupted run can go on."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from qrobot._files import StrPath, path_text, read_text, refusal, write_text_atomic
from qrobot.errors import InputError
from qrobot.plan import check, read_plan
from qrobot.planning.result import Result
from qrobot.planning.waves.outcome import WAVES_SCHEMA, Wave, Waves
from qrobot.problem import Instance
from qrobot.problem.formats import write
from qrobot.problem.formats.native import to_text

__all__ = ["Folder", "fingerprint"]

SUMMARY = "waves.json"


def fingerprint(pool: Instance) -> str:
    """Return what tells two pools apart."""
    return hashlib.sha256(to_text(pool).encode()).hexdigest()


class Folder:
    """Where the waves of one pool are written, each as soon as it is planned.

    Parameters
    ----------
    path
        The folder; it is made where it does not exist.
    asked
        How the pool is cut and planned, with its fingerprint.
    resume
        Whether finished waves that are there already stay.

    Raises
    ------
    InputError
        When waves are there and shall not stay, or were made of another pool or in another way.
    """

    def __init__(self, path: StrPath, asked: dict[str, Any], *, resume: bool) -> None:
        self.path, self.resume = Path(path_text(path)), resume
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise refusal("write", os.fspath(self.path), error) from None
        if not (self.path / SUMMARY).exists():
            self.resume = False
            return
        if not resume:
            raise InputError(
                "has waves already",
                source=os.fspath(self.path),
                advice="go on with --resume, or give another folder",
            )
        before = self._before()
        for name, value in asked.items():
            if before.get(name) != value:
                what = "of another pool" if name == "pool" else f"with another {name}"
                raise InputError(
                    f"has waves that were made {what}",
                    source=os.fspath(self.path),
                    advice="give another folder, or ask as before",
                )

    def _before(self) -> dict[str, Any]:
        source = os.fspath(self.path / SUMMARY)
        try:
            data = json.loads(read_text(source))
        except ValueError:
            data = None
        if not isinstance(data, dict) or data.get("schema") != WAVES_SCHEMA:
            raise InputError(
                f"is not a summary of schema {WAVES_SCHEMA!r}",
                source=source,
                advice="give another folder",
            )
        asked = data.get("asked")
        return asked if isinstance(asked, dict) else {}

    def file(self, number: int, kind: str) -> Path:
        """Return the path of a wave's file, such as ``wave-003.plan.json``."""
        return self.path / f"wave-{number:03d}{kind}"

    def save(self, number: int, result: Result, question: Instance) -> None:
        """Write a wave's question and its plan."""
        write(question, self.file(number, ".json"))
        result.save(self.file(number, ".plan.json"))

    def kept(self, number: int, question: Instance, begins: float) -> Wave | None:
        """Return a wave that was finished before; None: it is to be planned."""
        path = self.file(number, ".plan.json")
        if not self.resume or not path.exists():
            return None
        plan = read_plan(path)
        found = json.loads(read_text(path)).get("result") or {}
        report = check(plan, question)
        if found.get("ended", "interrupted") == "interrupted" or not report.ok:
            return None
        assert report.measures is not None  # as it is of a right plan
        return Wave(
            number,
            question,
            plan,
            report.measures,
            begins,
            bound=float(found["bound"]),
            is_optimal=bool(found["is_optimal"]),
            ended=str(found["ended"]),
            seconds=float(found["timing"]["total"]),
        )

    def summarise(self, waves: Waves) -> None:
        """Write the summary of the waves so far."""
        write_text_atomic(self.path / SUMMARY, waves.to_json())
