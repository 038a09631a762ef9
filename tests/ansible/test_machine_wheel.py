"""The faults that the machine tests plant in a wheel still apply to today's sources.

The machine tests want root and minutes; a module that moved away would only be noticed there.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from machine_wheel import NO_MACHINE_CODE, NO_START, WRONG_PLANS, Edits

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    "edits", [WRONG_PLANS, NO_START, NO_MACHINE_CODE], ids=["wrong plans", "no start", "no code"]
)
def test_a_planted_fault_finds_its_place(edits: Edits) -> None:
    for name, (old, new) in edits.items():
        text = (ROOT / name).read_text()
        assert text.count(old) == 1, name
        compile(text.replace(old, new), name, "exec")
