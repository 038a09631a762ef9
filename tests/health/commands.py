"""The command ``qrobot health`` in this process, with planted results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from health import samples

import qrobot.health
from qrobot.cli import main
from qrobot.health import CheckResult

__all__ = ["code_of", "planted"]


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Let every check give a planted result, and the machine planted findings."""
    about: dict[str, Any] = {"status": {}, "findings": [], "ran": [], "options": {}}

    def run_all(checks: list[Any], limits: Any, **options: Any) -> list[CheckResult]:
        about["options"] = {**options, "limits": limits}
        for check in checks:
            options["progress"](check)
        about["ran"] = [check.name for check in checks]
        return [samples.check(c.name, about["status"].get(c.name, "pass")) for c in checks]

    monkeypatch.setattr(qrobot.health, "run_all", run_all)
    monkeypatch.setattr(
        qrobot.health, "system_findings", lambda network=False: list(about["findings"])
    )
    return about


def code_of(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as done:
        main(["health", *map(str, words)])
    return int(done.value.code or 0)
