"""The page about health says what the code does."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from health import samples
from health.commands import code_of

from qrobot.cli.health import command
from qrobot.health import PROFILES, Report, system_findings
from qrobot.health.reports import compare, metrics
from qrobot.health.reports.compare import LARGER, MEGABYTES, SECONDS, SLOWER
from qrobot.health.system.hardware import HOT
from qrobot.health.system.memory import FULL, LOW, SMALL, TIGHT
from qrobot.health.system.network import SERVICES

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


def rules() -> dict[str, str]:
    """Return the alerts of the file that the page names."""
    yaml: Any = pytest.importorskip("yaml", reason="PyYAML is not installed")
    assert "`ansible/prometheus/alerts.yml`" in PAGE.read_text()
    (group,) = yaml.safe_load((PAGE.parents[1] / "ansible/prometheus/alerts.yml").read_text())[
        "groups"
    ]
    return {rule["alert"]: rule["expr"] for rule in group["rules"]}


def test_the_alert_fires_for_whatever_is_unhealthy() -> None:
    name, number = rules()["RobotUnhealthy"].split(" == ")

    def fires(one: Report) -> bool:
        (value,) = [s.value for f in metrics(one).collect() for s in f.samples if s.name == name]
        return value == float(number)

    good = samples.report(required=True)
    assert not fires(good)
    assert fires(samples.changed(good, "numpy", status="absent"))
    assert fires(samples.changed(good, "numpy", status="error"))
    assert fires(samples.found(good, "memory", status="fault"))
    assert not fires(samples.found(good, "memory", status="warning"))


def test_the_alert_fires_when_nothing_was_ever_written() -> None:
    # What the rules do with it is tried by promtool: ansible/prometheus/alerts.test.yml.
    (metric,) = re.findall(r"qrobot_health_\w+", rules()["RobotHealthNotChecked"])
    assert rules()["RobotHealthMissing"].endswith(f"unless on (job, instance) {metric}")
    assert "`RobotHealthMissing`" in PAGE.read_text()


def test_the_jobs_of_the_page_notice_an_absent_stack(
    planted: dict[str, Any], tmp_path: Path
) -> None:
    jobs = re.findall(r"^[\d*/]+ .* robot +qrobot health (.*?) ?>", PAGE.read_text(), re.MULTILINE)
    assert len(jobs) == 2
    for job in jobs:
        words = [re.sub(r"^/var/lib/.*/", f"{tmp_path}/", word) for word in job.split()]
        if "--compare" in words:
            at = words.index("--compare")
            assert code_of(*words[:at], *words[at + 2 :]) == 0  # as the page says: once without
        assert code_of(*words) == 0
        planted["status"] = {"dimod": "absent"}
        assert code_of(*words) == 1
        planted["status"] = {}


def test_the_table_of_drift_is_that_of_the_code() -> None:
    rows = [line.split(" | ") for line in PAGE.read_text().splitlines() if line.startswith("| ")]
    told = {row[0].strip("| "): row[-1] for row in rows if len(row) == 3}
    for name, fact in (
        ("status of a steady finding", "memory"),
        ("status of a finding that changes all the time, such as the temperature", "temperature"),
    ):
        one = samples.found(samples.report(), fact, status="good")
        other = samples.found(one, fact, status="warning")
        assert bool(compare(one, other).drift) == ("--strict-compare" in told[name])
        fault = samples.found(one, fact, status="fault")
        assert bool(compare(one, fault).worse) == ("when it became a fault" in told[name])


def test_every_profile_is_explained() -> None:
    for profile in PROFILES:
        assert f"| `{profile}` |" in PAGE.read_text()


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
