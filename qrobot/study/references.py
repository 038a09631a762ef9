"""What is known about the files of a benchmark: the values of an ``index.json``.

It is a list of objects. ``file`` is the path of an instance from the folder of the index,
``value`` the least distance that is known and ``status`` whether it is ``optimal`` or ``best
known``. Further values, by the name of a `variants.VARIANTS`, are of the same file changed.
"""

from __future__ import annotations

import os
from collections import Counter
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from qrobot._files import read_text
from qrobot.errors import InputError
from qrobot.problem.checks import is_reference
from qrobot.problem.formats.jsontext import loads
from qrobot.study.variants import VARIANTS

__all__ = ["Reference", "reference_of"]


class Reference(NamedTuple):
    """A value that costs are compared with, and what is known of it."""

    value: float
    status: str | None


def reference_of(path: Path, root: Path, variant: str | None = None) -> Reference | None:
    """Return what the nearest index that has a file says about it.

    Parameters
    ----------
    path
        An instance.
    root
        The folder of the comparison: indices are looked for from the file's folder up to the
        one above this.
    variant
        The variant of the instance, by name.

    Raises
    ------
    InputError
        When an index cannot be read; one above the root may be something else.
    """
    path, root = path.absolute(), root.absolute()
    for folder in path.parents:
        if folder == root.parent and folder != path.parent:
            try:
                known = _index(folder)
            except InputError:
                return None
        else:
            known = _index(folder)
        entry = known.get(path.relative_to(folder).as_posix()) or known.get(path.name)
        if entry is not None:
            return entry.get(variant)
        if folder == root.parent:
            break
    return None


@lru_cache(maxsize=64)
def _index(folder: Path) -> dict[str, dict[str | None, Reference]]:
    """Return the values of a folder's ``index.json`` by file and variant, when there is one.

    Files are known by path, and by name where no two in the index share it. Values that no gap
    can be measured from (0, negative or huge) are left out.
    """
    index = folder / "index.json"
    if not index.is_file():
        return {}
    try:
        entries = {e["file"]: _references(e) for e in loads(read_text(index))}
        names = Counter(PurePosixPath(file).name for file in entries)
    except InputError as error:
        raise error.in_file(os.fspath(index)) from None
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
        raise InputError(
            f"cannot be read ({type(error).__name__}: {error})",
            source=os.fspath(index),
            advice="give a list of objects with file and value, or remove it",
        ) from None
    by_name = {PurePosixPath(file).name: known for file, known in entries.items()}
    return {name: known for name, known in by_name.items() if names[name] == 1} | entries


def _references(entry: dict[str, Any]) -> dict[str | None, Reference]:
    """Return the values of an entry: its own, and those of variants of the file."""
    found: dict[str | None, Reference] = {}
    status = entry.get("status")
    for name in (None, *VARIANTS):
        value, proven = entry.get(name or "value"), status
        if isinstance(value, dict):
            proven = "optimal" if value.get("proven") else "best known"
            value = value["value"]
        if value is not None and is_reference(float(value)):
            found[name] = Reference(float(value), None if proven is None else str(proven))
    return found
