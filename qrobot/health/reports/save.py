"""Writes one report in its formats; one that cannot be written does not keep back the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qrobot._files import StrPath, write_text_atomic
from qrobot._json import json_text
from qrobot.errors import InputError
from qrobot.health.model import Report
from qrobot.health.reports.compare import Comparison
from qrobot.health.reports.junit import junit
from qrobot.health.reports.pages import html
from qrobot.health.reports.prometheus import write_prometheus

__all__ = ["as_json", "save"]


def document(report: Report, comparison: Comparison | None = None) -> dict[str, Any]:
    """Return plain data, with the comparison as a field of its own where there is one."""
    data = report.to_dict()
    if comparison is not None:
        data["comparison"] = comparison.to_dict()
    return data


def as_json(report: Report, comparison: Comparison | None = None) -> str:
    """Return the document as text."""
    return json_text(document(report, comparison), indent=1, ensure_ascii=False)


def save(
    report: Report,
    comparison: Comparison | None = None,
    *,
    output: StrPath | None = None,
    junit_path: StrPath | None = None,
    html_path: StrPath | None = None,
    prometheus: StrPath | None = None,
) -> list[InputError]:
    """Write every format that has a path, each whole or not at all.

    Returns
    -------
    list of InputError
        One for each that could not be written: what stood there before is untouched.
    """
    formats: list[tuple[StrPath | None, Callable[[StrPath], None]]] = [
        (output, lambda path: write_text_atomic(path, as_json(report, comparison) + "\n")),
        (junit_path, lambda path: write_text_atomic(path, junit(report))),
        (html_path, lambda path: write_text_atomic(path, html(report, comparison))),
        (prometheus, lambda path: write_prometheus(path, report)),
    ]
    troubles = []
    for path, write in formats:
        if path is not None:
            try:
                write(path)
            except InputError as error:
                troubles.append(error)
    return troubles
