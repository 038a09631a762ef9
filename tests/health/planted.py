"""Checks that somebody planted: files in a temporary folder that is put on the path."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from qrobot.health import Check

Plant = Callable[..., Check]

CREDENTIALS = (
    "AWS_PROFILE", "AWS_SECRET_ACCESS_KEY", "DWAVE_API_TOKEN", "GITHUB_TOKEN", "HTTPS_PROXY",
    "IBMQ_TOKEN", "IBM_CLOUD_API_KEY", "IQP_API_TOKEN", "JUPYTER_TOKEN", "SOME_SERVICE_PASSWORD",
    "aws_session_token", "https_proxy",
)  # fmt: skip
"""Variables that hold one, or may."""

SOURCE = """
from qrobot.health.check import Check
{top}
def answer():
{body}

def expected():
    return [1.0]

CHECK = Check(
    module=__name__, title="planted", group="base", imports={imports!r},
    distributions={distributions!r}, source="planted",
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
            source="planted",
        )

    return make


def left_behind(folder: Path) -> list[Path]:
    return list(folder.glob("qrobot-health-*"))
