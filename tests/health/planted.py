"""Checks that somebody planted: files in a temporary folder that is put on the path."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from qrobot.health import Check

Plant = Callable[..., Check]

SOURCE = """
from qrobot.health.check import Check
{top}
def answer():
{body}

CHECK = Check(
    module=__name__, title="planted", group="base", imports={imports!r},
    distributions={distributions!r}, answer=answer, expected=lambda: [1.0], source="planted",
)
"""


def planter(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Plant:
    """Return what makes a check from the body of its answer; the right one is ``[1.0]``."""
    monkeypatch.syspath_prepend(str(folder))

    def make(
        name: str,
        body: str,
        *,
        top: str = "",
        imports: tuple[str, ...] = (),
        distributions: tuple[str, ...] = ("numpy",),
    ) -> Check:
        source = SOURCE.format(
            top=top,
            body=textwrap.indent(textwrap.dedent(body).strip(), "    "),
            imports=imports,
            distributions=distributions,
        )
        (folder / f"planted_{name}.py").write_text(source)
        return Check(
            module=f"planted_{name}",
            title="planted",
            group="base",
            imports=imports,
            distributions=distributions,
            answer=list,  # what counts is the file
            expected=list,
            source="planted",
        )

    return make
