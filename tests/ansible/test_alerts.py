"""The alert rules: promtool's own tests, and that they fit the timer and the metrics."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from health.samples import report

from qrobot.health.reports.formats import GAUGES, metrics

yaml = pytest.importorskip("yaml")

ANSIBLE = Path(__file__).resolve().parents[2] / "ansible"
RULES = ANSIBLE / "prometheus/alerts.yml"
ROLE = ANSIBLE / "roles/health"


def promtool(*words: str | Path) -> subprocess.CompletedProcess[str]:
    program = shutil.which("promtool")
    if program is None:
        pytest.skip("promtool is not installed: it comes with Debian's package prometheus")
    return subprocess.run([program, *words], capture_output=True, text=True, check=False)


def test_promtool_accepts_the_rules() -> None:
    done = promtool("check", "rules", RULES)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_rules_alert_when_they_should_and_only_then() -> None:
    done = promtool("test", "rules", RULES.with_name("alerts.test.yml"))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("> 26 * 3600", "> 3600"),  # an alert for 23 hours of every day
        ("> 26 * 3600", "> 48 * 3600"),
        ("unless on (job, instance)", "and on (job, instance)"),
        ("qrobot_health_healthy == 0", "qrobot_health_healthy == 1"),
        (">= 80", ">= 50"),
    ],
)
def test_the_tests_notice_a_rule_that_is_wrong(tmp_path: Path, right: str, wrong: str) -> None:
    text = RULES.read_text()
    assert text.count(right) == 1
    (tmp_path / "alerts.yml").write_text(text.replace(right, wrong))
    shutil.copy(RULES.with_name("alerts.test.yml"), tmp_path)
    done = promtool("test", "rules", tmp_path / "alerts.test.yml")
    assert done.returncode == 1, done.stdout


def test_every_rule_is_tried() -> None:
    names = set(re.findall(r"alert: (\w+)", RULES.read_text()))
    assert names
    tried = RULES.with_name("alerts.test.yml").read_text()
    assert [name for name in sorted(names) if name not in tried] == []


def test_the_rules_ask_for_metrics_that_are_exported() -> None:
    pytest.importorskip("prometheus_client")
    exported = {family.name for family in metrics(report("a")).collect()}
    # Gauges that a machine without the sensor leaves out.
    exported |= {f"qrobot_health_{name}" for name, _, _ in GAUGES.values()}
    exported |= {"qrobot_health_throttled"}
    asked = set(re.findall(r"\bqrobot_health_\w+", RULES.read_text())) - {"qrobot_health_"}
    assert asked
    assert asked <= exported, asked - exported


def test_the_limit_fits_the_timer() -> None:
    calendar = yaml.safe_load((ROLE / "defaults/main.yml").read_text())["health_calendar"]
    assert re.fullmatch(r"\*-\*-\* \d\d:\d\d:\d\d", calendar), "once a day"
    timer = (ROLE / "templates/qrobot-health.timer.j2").read_text()
    found = re.search(r"RandomizedDelaySec=(\d+)min", timer)
    hours = re.search(r"run_timestamp_seconds > (\d+) \* 3600", RULES.read_text())
    assert found
    assert hours
    # From the begin of one run to the end of the next, with an hour for a slow robot.
    assert 24 * 3600 + int(found[1]) * 60 + 3600 <= int(hours[1]) * 3600 <= 30 * 3600
