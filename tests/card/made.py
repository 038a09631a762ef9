"""Seeds and keys to test with, and what parses the files back."""

from __future__ import annotations

import base64
from typing import Any

from qrobot.card import Seed


def line(kind: str, *parts: bytes, comment: str = "mira@desk") -> str:
    """A line of a public key file, put together by hand."""
    blob = b"".join(len(part).to_bytes(4, "big") + part for part in (kind.encode(), *parts))
    return f"{kind} {base64.b64encode(blob).decode()} {comment}".strip()


KEY = line("ssh-ed25519", bytes(range(32)))
OTHER_KEY = line("ssh-ed25519", bytes(range(1, 33)), comment="other")


def seed(**changes: Any) -> Seed:
    return Seed(**{"hostname": "robot-1", "user": "mira", "keys": (KEY,), **changes})


def name_of_keyfile(value: str) -> bytes:
    """What NetworkManager takes for the name of a Wi-Fi: nm-keyfile.c's rule, by its comment."""
    numbers = value.split(";")
    if len(numbers) > 1 and not numbers.pop().strip() and all(n.strip().isdigit() for n in numbers):
        return bytes(int(n) for n in numbers)
    assert "\\" not in value, "escapes are not written"
    return value.strip().encode()


HOSTILE = [
    "a: b #c\n'", "é😀;\\\"", "12;34;", "1234", " lead", "trail ", "-h", "--hidden", "x;y", "\\",
    "Café", "[x]", "#x", "null", "No", "~", "\x7f", "a\u2028b", "\x85x", "$(id)", ";", "- a", "{}",
]  # fmt: skip
