"""The one writer of CSV: what it writes is text and numbers to a spreadsheet, never a formula."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

__all__ = ["csv_text"]

FORMULA = re.compile(r"(^|[,;|\t\r\n])([\s\"']*)(?=[=+\-@＝＋－＠])")
"""Where a formula would begin: also after what another program takes for the end of a cell."""


def csv_text(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """Return some columns of rows as CSV, with a header.

    A spreadsheet computes a cell that begins with ``=``, ``+``, ``-`` or ``@``, and a name may
    begin so. Such a text gets an apostrophe before that character, which makes it text. Numbers
    stay numbers.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: _harmless(row[name]) for name in columns})
    return text.getvalue()


def _harmless(cell: Any) -> Any:
    if not isinstance(cell, str):
        return cell
    lines = cell.replace("\r\n", "\n").replace("\r", "\n")  # Python's writer leaves \r unquoted
    return FORMULA.sub(r"\1\2'", lines)
