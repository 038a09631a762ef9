"""What the tests of several commands read."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli.test_commands import QUESTION, qrobot


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A right plan of `QUESTION`."""
    path = tmp_path_factory.mktemp("plan") / "plan.json"
    assert qrobot("solve", QUESTION, "-o", path).returncode == 0
    return path
