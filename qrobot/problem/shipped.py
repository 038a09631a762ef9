"""The examples that come with qRobot, by name: ``example`` is the small warehouse."""

from __future__ import annotations

import os
from pathlib import Path

from qrobot.errors import InputError
from qrobot.problem.formats.registry import suffixes

__all__ = ["example_path"]

PLACES = (
    Path(__file__).resolve().parents[1] / "examples",  # in an installed package
    Path(__file__).resolve().parents[2] / "examples",  # in a checkout
)


def example_path(path: str | os.PathLike[str]) -> Path | None:
    """Return the file of ``example`` or ``example:NAME``, None when that is not meant.

    A file that has this name comes first.
    """
    text = os.fspath(path)
    if os.path.lexists(text):
        return None
    if text == "example":
        name = "small-warehouse"
    elif text.startswith("example:"):
        name = text.removeprefix("example:")
    else:
        return None
    found = {
        file.stem: file
        for place in PLACES
        for file in sorted(place.glob("*"))
        if file.suffix in suffixes() and file.stem != "layout"
    }
    if name not in found:
        raise InputError(
            "there is no such example",
            source=text,
            advice="use one of " + ", ".join(f"example:{known}" for known in sorted(found)),
        )
    return found[name]
