"""Why a cell stays empty."""

from __future__ import annotations

__all__ = ["Left"]


class Left(Exception):  # noqa: N818 - it is no error: the reason stands in the table
    """A method cannot run on a row here; the text says why."""
