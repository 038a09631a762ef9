"""Fonts that have the characters of all names: Matplotlib's own first, then what is installed."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import lru_cache
from typing import Any

__all__ = ["OWN", "choose", "families", "font_notes"]

OWN = "DejaVu Sans"
"""Comes with Matplotlib."""

Covers = Callable[[str, frozenset[str]], frozenset[str]]
"""Which of some characters a family has."""

# These have a box for every character, or none that can be drawn as an outline.
_USELESS = re.compile(r"last ?resort|blank|emoji|barcode|symbols? ?2? ?legacy", re.IGNORECASE)
# A text of CJK in four families is a patchwork: the plain ones are asked first.
_PLAIN = ("Noto Sans CJK", "Noto Sans", "Source Han Sans", "Droid Sans", "WenQuanYi", "FreeSans")


def choose(
    needed: Iterable[str], installed: Callable[[], Iterable[str]], covers: Covers
) -> tuple[list[str], str]:
    """Return the families to draw with, and the characters that none of them has.

    Parameters
    ----------
    needed
        All characters that are drawn.
    installed
        Tells the families that are there; asked only when our own does not do.
    covers
        Which of some characters a family has.
    """
    left = frozenset(c for c in needed if not _invisible(c))
    left -= covers(OWN, left)
    found = [OWN]
    if not left:
        return found, ""
    usable = sorted({f for f in installed() if f != OWN and not _USELESS.search(f)}, key=_rank)
    having = {family: covers(family, left) for family in usable}
    while left:
        best = max(usable, key=lambda family: len(having[family] & left), default=None)
        if best is None or not having[best] & left:
            break
        found.append(best)
        left -= having[best]
    return found, "".join(sorted(left))


def _rank(family: str) -> tuple[int, int, str]:
    plain = next((k for k, name in enumerate(_PLAIN) if family.startswith(name)), len(_PLAIN))
    return plain, len(family), family


def _invisible(character: str) -> bool:
    return character.isspace() or unicodedata.category(character) in {"Cf", "Cc", "Mn", "Me"}


def families(texts: Iterable[str]) -> tuple[list[str], str]:
    """Return the families to draw some texts with, and the characters that no font here has."""
    needed = frozenset("".join(texts))
    if needed <= _ascii():
        return [OWN], ""
    return choose(needed, _installed, _covers)


def font_notes(missing: str, texts: Iterable[str]) -> list[str]:
    """Return what a person should know of the names on a picture, a sentence each."""
    notes = []
    if missing:
        scripts = sorted({unicodedata.name(c, "an unknown script").split(" ")[0] for c in missing})
        shown = missing if len(missing) <= 8 else f"{missing[:8]}..."
        notes.append(
            f"no installed font has {len(missing)} of the characters in the names ({shown}, "
            f"{', '.join(scripts[:4])}): they are boxes in the picture; install a font that has "
            "them, such as Debian's fonts-noto-core or fonts-noto-cjk, or write .svg"
        )
    if not _orders() and any(unicodedata.bidirectional(c) in {"R", "AL"} for t in texts for c in t):
        notes.append(
            "names from right to left are drawn in the wrong order by this Matplotlib; "
            "use version 3.11 or newer, or write .svg"
        )
    return notes


def _ascii() -> frozenset[str]:
    return frozenset(map(chr, range(128)))


def _orders() -> bool:
    """Return whether Matplotlib orders and joins letters (it does by libraqm, since 3.11)."""
    from matplotlib import ft2font

    return hasattr(ft2font, "__libraqm_version__")


@lru_cache(maxsize=1)
def _installed() -> dict[str, list[str]]:
    """Return the upright files of every family.

    Matplotlib's own list is as old as its cache: fonts that came later are added to it.
    """
    from matplotlib.font_manager import findSystemFonts, fontManager

    known = {os.path.realpath(entry.fname) for entry in fontManager.ttflist}
    for path in sorted(findSystemFonts()):
        if os.path.realpath(path) not in known:
            with suppress(OSError, RuntimeError, ValueError, KeyError):  # a damaged file
                fontManager.addfont(path)
    found: dict[str, list[str]] = {}
    for entry in fontManager.ttflist:
        if entry.style == "normal":
            found.setdefault(entry.name, []).append(entry.fname)
    return found


def _own() -> list[str]:
    from matplotlib import get_data_path

    return [f"{get_data_path()}/fonts/ttf/DejaVuSans{weight}.ttf" for weight in ("", "-Bold")]


def _covers(family: str, characters: frozenset[str]) -> frozenset[str]:
    """Return what the family has in all its weights: titles are bold."""
    left = characters
    for path in _own() if family == OWN else _installed()[family]:
        font = _font(path)
        if font is None or not left:
            return frozenset()
        left = frozenset(c for c in left if font.get_char_index(ord(c)))
    return left


def _font(path: str) -> Any:
    from matplotlib.ft2font import FT2Font

    try:
        font = FT2Font(path)
    except (OSError, RuntimeError, ValueError):
        return None  # a damaged file, or a kind that cannot be drawn
    return font if getattr(font, "scalable", True) else None
