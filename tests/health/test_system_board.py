"""What the firmware of a Raspberry Pi says, and tools that do not say it."""

from __future__ import annotations

from pathlib import Path

import pytest
from health.made_up import machine, told, vcgencmd


@pytest.mark.parametrize(
    ("said", "status", "words"),
    [
        ("throttled=0x0", "good", ["not since the start"]),
        ("throttled=0x1", "warning", ["under-voltage now", "power supply"]),
        ("throttled=0x50005", "warning",
         ["under-voltage and throttled now", "under-voltage and throttled since the start"]),
        ("throttled=0xe0000", "warning",
         ["frequency capped and throttled and soft temperature limit since", "fan"]),
        ("throttled=0xZZ", "unknown", ["group video"]),
        ("VCHI initialization failed", "unknown", ["group video"]),
        ("", "unknown", ["group video"]),
    ],
)  # fmt: skip
def test_throttling_bits_are_decoded(
    tmp_path: Path, no_tool: Path, said: str, status: str, words: list[str]
) -> None:
    vcgencmd(no_tool, f"echo '{said}'")
    finding = told(machine(tmp_path))["throttled"]
    assert finding.status == status
    for word in words:
        assert word in finding.message


@pytest.mark.parametrize(
    "script", ["exit 1", "exec sleep 60", "head -c 300000 /dev/urandom", "kill -9 $$"]
)
def test_a_broken_vcgencmd_harms_nothing(
    tmp_path: Path, no_tool: Path, monkeypatch: pytest.MonkeyPatch, script: str
) -> None:
    monkeypatch.setenv("PATH", f"{no_tool}:/usr/bin:/bin")
    vcgencmd(no_tool, script)
    assert told(machine(tmp_path))["throttled"].status == "unknown"


def test_a_vcgencmd_that_is_no_program_harms_nothing(tmp_path: Path, no_tool: Path) -> None:
    (no_tool / "vcgencmd").write_bytes(b"\x7fELFnonsense")
    (no_tool / "vcgencmd").chmod(0o755)
    assert told(machine(tmp_path))["throttled"].status == "unknown"
