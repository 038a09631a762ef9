"""The gate room is in the making: its tests run where its compiled kernels can be had."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if importlib.util.find_spec("numba") is None:
        reason = pytest.mark.skip(reason="numba is not installed (extra braket or edge)")
        for item in items:
            if HERE in Path(item.path).parents:
                item.add_marker(reason)
