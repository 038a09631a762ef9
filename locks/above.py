"""Print the part of a lock that another lock does not bring to a machine.

Usage: python -m locks.above LOCK LOCK-BELOW ARCH

Both have one version of a package (`make lint` holds them to it), so a layer can leave out by
name what the layer below it holds. A pin below whose marker does not hold there brings nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path

from locks import MACHINES, pins


def main() -> None:
    lock, below = (Path(name).read_text() for name in sys.argv[1:3])
    machine = MACHINES[sys.argv[3]]
    there = {pin.name for pin in pins(below, machine)}
    print("".join(pin.text for pin in pins(lock, machine) if pin.name not in there), end="")


if __name__ == "__main__":
    main()
