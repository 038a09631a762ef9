"""Cases of a test that only `make test-slow` runs."""

from __future__ import annotations

from typing import Any

import pytest

__all__ = ["slow"]


def slow(value: object) -> Any:
    """Return a value of a parametrised test as one of a slow test."""
    return pytest.param(value, marks=pytest.mark.slow)
