"""Settings that every test shares."""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings
from processes import children, end, until

# Two workers whose linear algebra wants both cores would mostly wait for each other. Read when
# numpy is imported, so before anything else.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Times depend on the machine and on what else runs on it: examples have no deadline. In CI the
# same examples are drawn every time, so that a failure there can be repeated anywhere.
settings.register_profile("here", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", parent=settings.get_profile("here"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")

# Under nohup or in a background of a shell these are ignored, and every program that a test starts
# would inherit it: a test that sends one would wait for ever.
for _number, _usual in (
    (signal.SIGHUP, signal.SIG_DFL),
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGTERM, signal.SIG_DFL),
):
    if signal.getsignal(_number) is signal.SIG_IGN:
        signal.signal(_number, _usual)


PATIENCE = float(os.environ.get("QROBOT_TEST_PATIENCE", "60"))
"""Seconds that a process which was told to end may take for it."""


@pytest.fixture(autouse=True)
def _no_child_outlives_its_test(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that leaves a process behind, and end what a failing test left."""
    before, failed = children(), request.session.testsfailed
    yield
    left = children() - before
    try:
        if request.session.testsfailed == failed:  # what was told to end may need a moment
            until(lambda: not children() & left, f"{left} were left behind", patience=PATIENCE)
    finally:
        end(left)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Sum the skipped tests up in one line; what failed comes after it."""
    reasons: Counter[str] = Counter()
    for report in terminalreporter.stats.get("skipped", []):
        told = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        reasons[told.removeprefix("Skipped: ").split(":")[0]] += 1
    if reasons:
        each = "; ".join(f"{count} {reason}" for reason, count in reasons.most_common())
        terminalreporter.write_line(f"{reasons.total()} skipped: {each}")
