"""Two reports held against each other: what drifted, and whether it got worse."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from qrobot._text import Table, count
from qrobot.health.model import CheckResult, Report
from qrobot.health.reports.summary import facts, when

__all__ = ["RANK", "Change", "Comparison", "compare"]

SLOWER, SECONDS = 1.5, 0.5
"""A time is shown when it changed by this factor and by so many seconds."""

LARGER, MEGABYTES = 1.25, 50.0
"""So is the memory, in MiB."""

ANSWER = 1e-9
"""Largest absolute difference of an answer's number that is not shown."""

RANK = {"pass": 0, "absent": 1, "fail": 2, "error": 2}

Kind = Literal["status", "machine", "version", "answer", "time", "memory"]


@dataclass(frozen=True)
class Change:
    """One thing that is not what it was.

    Parameters
    ----------
    kind, name
        What changed: of which check, package or fact.
    before, after
        As text; ``-`` where there was or is none.
    worse
        A check that got worse, or a fact that became a fault.
    steady
        Whether it stays as it is when nobody changes the machine; a temperature does not.
    """

    kind: Kind
    name: str
    before: str
    after: str
    worse: bool = False
    steady: bool = True


@dataclass(frozen=True)
class Comparison:
    """All changes from one report to another.

    Parameters
    ----------
    before, after
        The reports.
    changes
        The gravest kind first.
    apart
        Checks that are in one of the reports only.
    """

    before: Report
    after: Report
    changes: tuple[Change, ...]
    apart: tuple[str, ...]

    @property
    def worse(self) -> list[Change]:
        """The changes that make the exit code 1."""
        return [change for change in self.changes if change.worse]

    @property
    def drift(self) -> list[Change]:
        """The changes that ``--strict-compare`` does not forgive.

        All but times, memory and the weather: what is another at every moment only counts when
        it became a fault.
        """
        return [
            change
            for change in self.changes
            if change.kind not in ("time", "memory") and (change.steady or change.worse)
        ]

    def table(self) -> Table:
        """Return one row a change."""
        return Table(
            "Changes",
            ("name", "what", "before", "after", "verdict"),
            tuple(
                (c.name, c.kind, c.before, c.after, "worse" if c.worse else "")
                for c in self.changes
            ),
            status=4,
        )

    def headline(self) -> str:
        """Return which reports were compared, and the verdict."""
        old, new = self.before, self.after
        verdict = f"{count(len(self.changes), 'change')}, {len(self.worse)} for the worse"
        apart = f"; in one of them only: {', '.join(self.apart)}" if self.apart else ""
        return f"{new.host} {when(new)} against {old.host} {when(old)}: {verdict}{apart}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "schema": "qrobot.health.comparison/1",
            "before": {"host": self.before.host, "made": self.before.made},
            "after": {"host": self.after.host, "made": self.after.made},
            "worse": len(self.worse),
            "drift": len(self.drift),
            "apart": list(self.apart),
            "changes": [asdict(change) for change in self.changes],
        }


def compare(before: Report, after: Report) -> Comparison:
    """Return what changed from one report to another.

    Only checks and facts that are in both are compared; a check that is in one of them only is
    named, because what is run is chosen anew every time.
    """
    old = {check.name: check for check in before.checks}
    new = {check.name: check for check in after.checks}
    both = [(old[name], new[name]) for name in new if name in old]
    changes = [
        *(_status(*pair) for pair in both),
        *_findings(before, after),
        *_machine(before, after),
        *_versions(before, after, both),
        *(_answer(*pair) for pair in both),
        *(_time(*pair) for pair in both),
        *(_memory(*pair) for pair in both),
    ]
    found = tuple(change for change in changes if change is not None)
    return Comparison(before, after, found, tuple(sorted(old.keys() ^ new.keys())))


def _status(old: CheckResult, new: CheckResult) -> Change | None:
    if old.status == new.status:
        return None
    worse = RANK[new.status] > RANK[old.status]
    return Change("status", new.name, old.status, new.status, worse)


def _findings(before: Report, after: Report) -> Iterator[Change]:
    for finding in after.system:
        old = before.finding(finding.name)
        if old is not None and old.status != finding.status:
            worse = finding.status == "fault"
            yield Change("status", finding.name, old.status, finding.status, worse, finding.steady)


def _machine(before: Report, after: Report) -> Iterator[Change]:
    old, new = facts(before), facts(after)
    for name in new:
        if name in old and old[name] != new[name]:
            yield Change("machine", name, old[name], new[name])


def _versions(
    before: Report, after: Report, both: list[tuple[CheckResult, CheckResult]]
) -> Iterator[Change]:
    old, new = {"qrobot": before.qrobot}, {"qrobot": after.qrobot}
    for one, other in both:
        old |= one.versions
        new |= other.versions
    for name in sorted(old | new):
        if old.get(name) != new.get(name):
            yield Change("version", name, old.get(name, "-"), new.get(name, "-"))


def _answer(old: CheckResult, new: CheckResult) -> Change | None:
    if old.answer is None or new.answer is None:
        return None  # the status says it
    if len(old.answer) != len(new.answer):
        return Change(
            "answer", new.name, f"{len(old.answer)} numbers", f"{len(new.answer)} numbers"
        )
    far, place = 0.0, None
    for k, (a, b) in enumerate(zip(old.answer, new.answer, strict=True)):
        if (a is None) != (b is None):
            far, place = float("inf"), k
        elif a is not None and b is not None and abs(a - b) > max(ANSWER, far):
            far, place = abs(a - b), k
    if place is None:
        return None
    where = f"number {place + 1}: "
    texts = [_number(value) for value in (old.answer[place], new.answer[place])]
    return Change("answer", new.name, where + texts[0], where + texts[1])


def _number(value: float | None) -> str:
    return "not finite" if value is None else f"{value:.12g}"


def _beyond(old: float | None, new: float | None, factor: float, floor: float) -> bool:
    if old is None or new is None:
        return False
    small, large = sorted((old, new))
    return large - small > floor and large > factor * small


def _time(old: CheckResult, new: CheckResult) -> Change | None:
    if not _beyond(old.seconds, new.seconds, SLOWER, SECONDS):
        return None
    return Change("time", new.name, f"{old.seconds:.1f} s", f"{new.seconds:.1f} s")


def _memory(old: CheckResult, new: CheckResult) -> Change | None:
    if not _beyond(old.peak_mb, new.peak_mb, LARGER, MEGABYTES):
        return None
    return Change("memory", new.name, f"{old.peak_mb:.0f} MB", f"{new.peak_mb:.0f} MB")
