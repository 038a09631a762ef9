"""The files that tell a first boot, for each release of Raspberry Pi OS."""

from __future__ import annotations

from qrobot.card import bookworm, trixie
from qrobot.card.model import Security, Seed, StaticAddress, Wifi
from qrobot.errors import InputError

__all__ = ["RELEASES", "Security", "Seed", "StaticAddress", "Wifi", "seed_files"]

RELEASES = {"trixie": trixie.files, "bookworm": bookworm.files}
"""Releases of Raspberry Pi OS, and who writes their files."""


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
            mend=f"use one of: {', '.join(RELEASES)}",
        )
    return RELEASES[release](seed)
