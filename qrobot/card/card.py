"""Files onto a boot partition: all that can be refused is refused before the first is written."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from qrobot._files import StrPath, write_text_atomic
from qrobot.card import bookworm, trixie
from qrobot.card.seed import Seed
from qrobot.errors import InputError

__all__ = ["RELEASES", "Written", "seed_files", "write_card"]

RELEASES = {"trixie": trixie.files, "bookworm": bookworm.files}
"""Releases of Raspberry Pi OS, and who writes their files."""

# What the files of a fresh image say beside comments; nobody loses anything with them.
_STOCK = {
    "network:", "version: 2", "ethernets:", "eth0:", "dhcp4: true", "optional: true",
    "ssh_pwauth: false", "dsmode: local", "instance_id: rpios-image", "instance-id: rpios-image",
}  # fmt: skip


@dataclass(frozen=True)
class Written:
    """What stands on a card.

    Parameters
    ----------
    files
        All files of the seed.
    changed
        Those that were written now; the others were the same before.
    warnings
        What a person should know, a sentence each.
    instance_id
        What cloud-init knows the seed by; none where it is not read by cloud-init.
    """

    files: tuple[Path, ...]
    changed: tuple[Path, ...]
    warnings: tuple[str, ...]
    instance_id: str | None


def seed_files(seed: Seed, release: str = "trixie") -> dict[str, str]:
    """Return name and text of every file, in the sequence they are to be written.

    Raises
    ------
    InputError
        When the release is unknown, or its first boot does not read what the seed holds.
    """
    if release not in RELEASES:
        raise InputError(
            f"{release!a} is not a release that is known",
            field="--release",
            advice=f"use one of: {', '.join(RELEASES)}",
        )
    return RELEASES[release](seed)


def write_card(
    folder: StrPath, texts: Mapping[str, str], release: str, *, force: bool = False
) -> Written:
    """Write the files of a seed, each whole or not at all, readable for its owner only.

    Parameters
    ----------
    folder
        The mounted boot partition, or any folder.
    texts
        Name and text of every file, as `seed_files` returns them.
    release
        Which release they are for.
    force
        Replace files that hold something else, and remove those of another seed.

    Raises
    ------
    InputError
        When the folder is none, a file cannot be written, or would be replaced without `force`.
    """
    place = Path(folder)
    if not place.is_dir():
        raise InputError(
            f"{os.fspath(folder)!r} is not a folder",
            field="DEST",
            advice="give the folder where the boot partition is mounted, such as /media/me/bootfs",
        )
    others = _of_another_seed(place, texts)
    if not force:
        _refuse_to_replace(place, texts, others)
    for name in texts:  # what cannot be read is refused before anything is written
        _read(place / name)
    warnings = tuple(_warnings(place, release))
    for path in others:
        _remove(path)
    changed = tuple(place / name for name, text in texts.items() if _write(place / name, text))
    identity = re.search(r'^instance-id: "(.*)"$', texts.get("meta-data", ""), re.MULTILINE)
    return Written(
        tuple(place / name for name in texts),
        changed,
        warnings,
        identity.group(1) if identity else None,
    )


def _of_another_seed(place: Path, texts: Mapping[str, str]) -> list[Path]:
    """Return files that a first boot may read too: they hold somebody's password or Wi-Fi key."""
    found = [place / name for name in (*trixie.NAMES, *bookworm.NAMES) if name not in texts]
    return [path for path in found if not _is_stock(_read(path) or b"")]


def _remove(path: Path) -> None:
    try:
        path.unlink()
    except OSError as error:
        raise InputError(
            f"cannot be removed: {error.strerror}", source=str(path), advice="remove it"
        ) from None


def _refuse_to_replace(place: Path, texts: Mapping[str, str], others: list[Path]) -> None:
    script = place / "firstrun.sh"
    if script.exists():
        raise InputError(
            "is there already and would set up the card in its own way",
            source=str(script),
            advice="write the card anew without settings, or use --force",
        )
    for name, text in texts.items():
        there = _read(place / name)
        if there is not None and there != text.encode() and not _is_stock(there):
            raise InputError(
                "holds other settings already",
                source=str(place / name),
                advice="look at it, then use --force to replace it",
            )
    if others:
        raise InputError(
            "is of other settings, and the first boot may read it too",
            source=str(others[0]),
            advice="look at it, then use --force to remove it",
        )


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(
            f"cannot be read: {error.strerror}", source=str(path), advice="move it away"
        ) from None


def _is_stock(data: bytes) -> bool:
    lines = [line.strip() for line in data.decode("utf-8", "replace").splitlines()]
    return {line for line in lines if line and not line.startswith("#")} <= _STOCK


def _write(path: Path, text: str) -> bool:
    """Write a file and return whether it was another before."""
    if _read(path) == text.encode():
        return False
    if path.exists():
        with contextlib.suppress(OSError):  # FAT knows no modes
            path.chmod(0o600)
    before = os.umask(0o077)
    try:
        write_text_atomic(path, text)
    finally:
        os.umask(before)
    return True


def _release_on(place: Path) -> str | None:
    """Return the release of the image by what it brought; none when a seed has replaced that."""
    brought = _read(place / "meta-data")
    if brought is None:
        return "bookworm"
    return None if brought.startswith(b"# Written by: qrobot") else "trixie"


def _warnings(place: Path, release: str) -> list[str]:
    found = []
    command_line = _read(place / "cmdline.txt")
    if command_line is None and not (place / "config.txt").exists():
        found.append(
            f"{place} has no config.txt and no cmdline.txt: it is not the boot partition of a Pi"
        )
    elif (_release_on(place) or release) != release:
        other = "bookworm" if release == "trixie" else "trixie"
        found.append(
            f"{place} looks like a card of {other}, whose first boot reads other files;"
            f" if it is, use --release {other}"
        )
    if (place / "firstrun.sh").exists():
        found.append(f"{place / 'firstrun.sh'} is still there and may change what was set here")
    if command_line and re.search(rb"\bds=nocloud\S*;i=", command_line):
        found.append(
            "cmdline.txt gives the card an identity of its own, so a card that has booted before"
            " does not take this seed: write the image anew, or remove ds=nocloud;i=... there"
        )
    return found
