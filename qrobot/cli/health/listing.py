"""The checks that there are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from qrobot._json import json_text

if TYPE_CHECKING:
    from qrobot.health import Check

__all__ = ["listing"]


def listing(checks: list[Check], as_json: bool) -> str:
    """Return the checks as a table or as JSON; none is run."""
    from qrobot._text import columns

    if as_json:
        rows: list[dict[str, Any]] = [
            {"name": c.name, "group": c.group, "title": c.title, "quick": c.quick,
             "profile": c.profile, "expected_from": c.source, "extra": c.extra,
             "versions": c.versions()}
            for c in checks
        ]  # fmt: skip
        return json_text(rows, indent=1)
    heads = ["check", "group", "computes", "quick", "profile", "installed"]
    return columns(
        heads,
        [
            [c.name, c.group, c.title, "yes" if c.quick else "no", c.profile,
             next(iter(c.versions().values()), "no")]
            for c in checks
        ],
    )  # fmt: skip
