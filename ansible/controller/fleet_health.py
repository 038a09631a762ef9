"""One page of the fleet's health, which names the robots that sent no report too.

Reads the reports that health.yml fetched, and on stdin which robots it asked. Exit codes: 0 every
robot is healthy, 1 one is not, 2 something given cannot be used, 3 a robot sent no report.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path

from common import ROOT, run, write_json

from qrobot._files import write_text_atomic
from qrobot.errors import InputError
from qrobot.health import Report, read_report
from qrobot.health.reports import fleet, fleet_html


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "fleet")
    folder = parser.parse_args().folder
    try:
        asked = {robot["name"]: str(robot["why"]) for robot in json.load(sys.stdin)}
    except (ValueError, TypeError, KeyError):
        advice = 'give [{"name": ROBOT, "why": "" or why it sent none}]'
        raise InputError("is not a list of robots", source="stdin", advice=advice) from None
    reports: list[Report] = []
    silent = []
    for name, absent in asked.items():
        report, why = None, absent
        try:
            path = folder / f"{name}.json"
            report = read_report(path) if path.exists() or not why else None
        except InputError as error:
            why = why or f"its report cannot be used: {error}"
        reports += [report] if report else []
        if why:
            why = " ".join(why.removeprefix("Task failed: ").split())
            shown = f"the report shown is of {report.made}" if report else "there is no earlier one"
            silent.append(f"{name} sent no report ({why}); {shown}")
    found = fleet(reports)
    # First what is not known: everything else is said of the robots that answered.
    found = dataclasses.replace(found, notes=(*silent, *found.notes))
    try:
        write_json(folder / "fleet.json", found.to_dict())
        write_text_atomic(folder / "fleet.html", fleet_html(found))
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", source=str(folder)) from None
    print("\n".join([*silent, *found.bad_lines(), found.headline()]))
    raise SystemExit(3 if silent else 1 if found.unhealthy else 0)


if __name__ == "__main__":
    sys.exit(run("fleet_health", main))
