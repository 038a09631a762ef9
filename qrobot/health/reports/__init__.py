"""A report as tables, JUnit XML, a page, metrics; and reports beside each other."""

from qrobot.health.reports.compare import Change, Comparison, compare
from qrobot.health.reports.fleet import Column, FleetHealth, fleet
from qrobot.health.reports.formats import (
    as_json,
    document,
    fleet_html,
    html,
    junit,
    metrics,
    save,
    write_prometheus,
)
from qrobot.health.reports.summary import (
    attention,
    checks_table,
    machine_line,
    system_table,
    totals_line,
)

__all__ = [
    "Change",
    "Column",
    "Comparison",
    "FleetHealth",
    "as_json",
    "attention",
    "checks_table",
    "compare",
    "document",
    "fleet",
    "fleet_html",
    "html",
    "junit",
    "machine_line",
    "metrics",
    "save",
    "system_table",
    "totals_line",
    "write_prometheus",
]
