"""What every benchmark does with its report."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

__all__ = ["write"]


def write(report: dict[str, Any], path: Path | None, markdown: Path | None = None) -> None:
    """Write a report as JSON, and its table as Markdown, where they are asked for.

    Parameters
    ----------
    report
        Plain data; its table is under ``markdown``.
    path, markdown
        Files, made with their folders; ``None``: not wanted.
    """
    for target, text in (
        (path, json.dumps(report, indent=1) + "\n"),
        (markdown, report.get("markdown", "")),
    ):
        if target is not None:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
