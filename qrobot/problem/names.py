"""Names that look the same are the same: Unicode's composed form, and nothing invisible.

One program writes a letter and its accent as one character, another as two; a person sees no
difference. Characters that cannot be seen, or that turn the direction of writing, would let
two names look alike that are not.
"""

from __future__ import annotations

import unicodedata

__all__ = ["canonical", "first_invisible"]


def canonical(name: str) -> str:
    """Return a name in normal form C, every kind of space as a plain one."""
    if name.isascii():
        return name
    name = unicodedata.normalize("NFC", name)
    return "".join(" " if unicodedata.category(c) == "Zs" else c for c in name)


def first_invisible(name: str) -> str | None:
    """Return the code of the first character that cannot be printed, such as ``U+200B``."""
    if name.isprintable():
        return None
    return next((f"U+{ord(c):04X}" for c in canonical(name) if not c.isprintable()), None)
