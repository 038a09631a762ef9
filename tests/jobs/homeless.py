"""A user whom the system does not know, as in ``docker run --user 12345``."""

from __future__ import annotations

import pwd
from typing import NoReturn

import pytest


def homeless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the user's home away: no variable names it, and no entry of the system."""

    def unknown(_: object) -> NoReturn:
        raise KeyError("no such user")

    for name in ("getpwuid", "getpwnam"):
        monkeypatch.setattr(pwd, name, unknown)
    for name in ("HOME", "XDG_CONFIG_HOME"):
        monkeypatch.delenv(name, raising=False)
