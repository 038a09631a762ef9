"""Print the part of a lock that another lock does not bring to a machine.

Usage: above.py LOCK LOCK-BELOW ARCH

Both have one version of a package (`make lint` holds them to it), so a layer can leave out by
name what the layer below it holds. A pin below whose marker does not hold there brings nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path

from lock import pins


def main() -> None:
    lock, below, arch = sys.argv[1:]
    there = {pin.name for pin in pins(Path(below).read_text(), arch)}
    print(
        "".join(pin.text for pin in pins(Path(lock).read_text(), arch) if pin.name not in there),
        end="",
    )


if __name__ == "__main__":
    main()
