"""Text of others, such as another machine's report, made fit for a terminal."""

from __future__ import annotations

import re

__all__ = ["plain"]

UNFIT = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters (a terminal obeys them), what turns the direction of writing, and what no
UTF-8 can hold."""


def plain(text: str) -> str:
    """Return a text in one line with a sign in place of every character that is not shown."""
    return UNFIT.sub("\ufffd", text)
