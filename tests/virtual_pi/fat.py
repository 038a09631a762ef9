"""Power cuts in the middle of the boot files, many at once: every part of what was being written.

The virtual Pi replaces boot files on a FAT disk of its own, and what the disk holds is kept after
every line of the module. A cut between two states leaves any part of the sectors that differ, for a
disk writes in an order of its own. Each such disk must hold the old or the new files, read as the
firmware reads them (as they are) and as the kernel does (after fsck).
"""

from __future__ import annotations

import base64
import itertools
import random
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SECTOR = 512
SIZE = 34 << 20  # near the smallest FAT32
ALL_PARTS_OF = 8  # sectors; of more, some parts


def parts(sectors: list[int], chance: random.Random) -> Iterator[tuple[int, ...]]:
    """Return the parts of what was being written that a cut may leave on the disk."""
    if len(sectors) <= ALL_PARTS_OF:
        for count in range(len(sectors) + 1):
            yield from itertools.combinations(sectors, count)
        return
    for at in range(len(sectors) + 1):
        yield tuple(sectors[:at])
        yield tuple(sectors[at:])
    for _ in range(200):
        yield tuple(one for one in sectors if chance.random() < 0.5)


def disk(files: dict[str, list[str]], folder: Path) -> bytes:
    """Return a FAT32 disk with the old files, as a card has them."""
    image = folder / "fat.img"
    image.write_bytes(bytes(SIZE))
    subprocess.run(["mkfs.vfat", "-F", "32", image], check=True, stdout=subprocess.DEVNULL)
    for name, (old, _) in files.items():
        command = ["mcopy", "-i", image, "-", f"::{name}"]
        subprocess.run(command, input=old.encode(), check=True)
    return image.read_bytes()


def text(image: Path, name: str) -> str:
    done = subprocess.run(["mtype", "-i", image, f"::{name}"], capture_output=True, check=False)
    return done.stdout.decode(errors="replace")


def cuts(
    begin: bytes, runs: list[list[dict[str, Any]]], files: dict[str, list[str]], folder: Path
) -> tuple[int, list[str]]:
    """Return how many disks were looked at, and sentences about those that lost a boot file.

    Parameters
    ----------
    begin
        The disk before.
    runs
        What fat_guest.py tells: not forced, and forced.
    files
        The old and the new text of each boot file.
    folder
        For the disk that is looked at.
    """
    chance = random.Random(0)
    looked, lost = 0, []
    image = folder / "fat.img"
    for forced, run in zip((False, True), runs, strict=True):
        held = bytearray(begin)
        for state in run:
            after = {int(n): base64.b64decode(data) for n, data in state["sectors"].items()}
            for part in parts(sorted(after), chance):
                cut = bytearray(held)
                for number in part:
                    cut[number * SECTOR : (number + 1) * SECTOR] = after[number]
                image.write_bytes(cut)
                looked += 1
                for reader in ("firmware", "kernel"):
                    if reader == "kernel":
                        subprocess.run(["fsck.vfat", "-a", image], capture_output=True, check=False)
                    for name, texts in files.items():
                        kept = text(image, f"{name}.before-qrobot")
                        if text(image, name) not in texts or kept not in ("", texts[0]):
                            lost.append(
                                f"{name} for the {reader}, line {state['line']}, "
                                f"sectors {part} of {sorted(after)}, forced {forced}"
                            )
            for number, data in after.items():
                held[number * SECTOR : (number + 1) * SECTOR] = data
        image.write_bytes(held)
        for name, (_, new) in files.items():
            if text(image, name) != new:
                lost.append(f"{name} is not the new one at the end")
    image.unlink()
    return looked, lost
