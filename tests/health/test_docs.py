"""The page about health says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from health import samples

from qrobot.cli.health import command
from qrobot.health import PROFILES, system_findings
from qrobot.health.reports import metrics
from qrobot.health.reports.compare import LARGER, MEGABYTES, SECONDS, SLOWER
from qrobot.health.system.board import HOT
from qrobot.health.system.endpoints import SERVICES
from qrobot.health.system.memory import FULL, LOW, SMALL, TIGHT

PAGE = Path(__file__).resolve().parents[2] / "docs" / "health.md"

pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="the docs are not in a wheel")


def test_every_finding_is_explained() -> None:
    text = PAGE.read_text()
    names = {finding.name for finding in system_findings()}
    assert len(names) == 19
    for name in names:
        assert f"`{name}`" in text, name
    for service in SERVICES:
        assert f"endpoint-{service}" in text or f"`-{service}`" in text


def test_the_thresholds_are_those_of_the_code() -> None:
    text = PAGE.read_text()
    for words in (
        f"below {LOW} MiB in the current folder", f"below {FULL} MiB", f"below {SMALL} MiB in all",
        f"below {TIGHT} MiB", f"{HOT:.0f} °C and more",
        f"by a factor of {SLOWER} and by {SECONDS} s",
        f"by a factor of {LARGER} and by {MEGABYTES:.0f} MiB",
    ):  # fmt: skip
        assert words in text


def test_every_metric_is_named() -> None:
    text = PAGE.read_text()
    for family in metrics(samples.report()).collect():
        name = family.name.removeprefix("qrobot_health_")
        short = f"`_{name.removeprefix('check_')}"
        assert f"`{family.name}`" in text or f"`_{name}`" in text or short in text, family.name
    for name in re.findall(r"expr: .*?(qrobot_health_\w+)", text):
        assert name in {family.name for family in metrics(samples.report()).collect()}


def test_every_option_that_is_named_exists() -> None:
    told = PAGE.read_text()
    known = {
        option
        for one in command.commands.values()
        for parameter in one.params
        for option in parameter.opts
    }
    for line in re.findall(r"qrobot health[^|\n`]*", told):
        assert set(re.findall(r"(?<= )--[a-z-]+", line)) <= known | {"--"}, line
    for name in ("--jobs", "--memory", "--timeout", "--no-system", "--network", "--notebooks"):
        assert name in told
        assert name in CliRunner().invoke(command, ["--help"]).output
    assert all(profile in told for profile in PROFILES)
