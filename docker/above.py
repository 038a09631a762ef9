"""Print the part of a lock whose packages another lock has not. Usage: above.py LOCK LOCK-BELOW

Both have one version of a package (`make lint` holds them to it), so a layer can leave out by
name what the layer below it holds.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

NAME = re.compile(r"^([A-Za-z0-9][A-Za-z0-9._-]*)==")


def blocks(lock: str) -> Iterator[tuple[str, str]]:
    """Yield each package's name and its lines, hashes and comments included."""
    name, lines = "", []
    for line in lock.splitlines(keepends=True):
        if match := NAME.match(line):
            yield name, "".join(lines)
            name, lines = match[1], []
        lines.append(line)
    yield name, "".join(lines)


def main() -> None:
    lock, below = (Path(path).read_text() for path in sys.argv[1:])
    there = {name for name, _ in blocks(below)}
    print("".join(text for name, text in blocks(lock) if name not in there), end="")


if __name__ == "__main__":
    main()
