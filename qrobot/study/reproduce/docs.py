"""Reproduced tables within a page of the documentation, between markers."""

from __future__ import annotations

import os
import re
from pathlib import Path

from qrobot._files import read_text, write_text_atomic
from qrobot.errors import InputError

__all__ = ["check_page", "fill_page"]

MARKERS = "<!-- reproduce:{0} -->", "<!-- end of {0} -->"


def check_page(path: str | os.PathLike[str]) -> str:
    """Return a page's text, when it has places to fill.

    Raises
    ------
    InputError
        When the page cannot be read or has no marker.
    """
    text = read_text(path)
    if "<!-- reproduce:" not in text:
        raise InputError(
            "has no place for a table",
            source=os.fspath(path),
            mend=f"write {' and '.join(MARKERS).format('table1')} into it, each on its own line",
        )
    return text


def fill_page(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> list[str]:
    """Put the Markdown files of a folder between a page's markers; return which.

    Pictures are left out: they lie in the folder.
    """
    text, filled = check_page(path), []
    for file in sorted(Path(folder).glob("*.md")):
        before, after = (marker.format(file.stem) for marker in MARKERS)
        place = re.compile(f"{re.escape(before)}\n.*?{re.escape(after)}", re.DOTALL)
        if place.search(text):
            lines = [line for line in read_text(file).splitlines() if not line.startswith("![")]
            body = re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip()
            made = f"{before}\n{body}\n\n{after}"
            text = place.sub(lambda _found, made=made: made, text)  # type: ignore[misc]
            filled.append(file.stem)
    write_text_atomic(path, text)
    return filled
