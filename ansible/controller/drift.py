"""Hold what robots have against the locks, against the release of this checkout, and together.

Reads what drift.yml wrote down. Prints a table; writes drift.json (schema qrobot.drift/1) and
drift.html. Exit codes: 0 no drift, 1 drift, 2 something given cannot be used, 3 a robot did not
answer (also when others drift: the answer is not whole).
"""

from __future__ import annotations

import argparse
import json
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from common import ROOT, run, write_json
from drift_compare import Checkout, compare
from drift_show import page, table

from qrobot._files import write_text_atomic
from qrobot.errors import InputError

SCHEMA = "qrobot.inventory/1"


def main() -> None:
    options = arguments()
    robots = read(options.inventory)
    document = compare(robots, Checkout(options.locks, options.wheelhouse))
    document["made"] = datetime.now(UTC).isoformat(timespec="seconds")
    try:
        write_json(options.dest / "drift.json", document)
        write_text_atomic(options.dest / "drift.html", page(document))
    except OSError as error:
        problem = f"cannot be written ({error.strerror})"
        raise InputError(problem, source=str(options.dest), field="--dest") from None
    print(table(document))
    totals = document["totals"]
    raise SystemExit(3 if totals["unreachable"] else 1 if totals["drift"] else 0)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    fleet = ROOT / "build" / "fleet"
    parser.add_argument("inventory", type=Path, nargs="?", default=fleet / "inventory.json",
                        help="what drift.yml wrote; default: %(default)s")  # fmt: skip
    parser.add_argument("--locks", type=Path, default=ROOT / "locks", help="folder of the locks")
    parser.add_argument("--wheelhouse", type=Path, default=ROOT / "build" / "wheelhouse",
                        help="folder of what wheelhouse.py collected")  # fmt: skip
    parser.add_argument("--dest", type=Path, default=fleet, help="folder of the answer")
    return parser.parse_args()


def read(path: Path) -> list[dict[str, Any]]:
    """Return the robots of a file, each with ``name``, ``settings``, ``why`` and ``inventory``."""
    advice = "run `make drift`"
    try:
        document = json.loads(path.read_text())
    except OSError as error:
        raise InputError(
            f"not readable ({error.strerror})", source=str(path), advice=advice
        ) from None
    except ValueError:
        raise InputError("is not JSON", source=str(path), advice=advice) from None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise InputError(f"is not {SCHEMA}", source=str(path), field="schema", advice=advice)
    robots = document.get("robots")
    for number, robot in enumerate(robots if isinstance(robots, list) else [None]):
        field = f"robots[{number}]"
        if not isinstance(robot, dict) or not {"name", "settings", "why", "inventory"} <= set(
            robot
        ):
            raise InputError("is not whole", source=str(path), field=field, advice=advice)
    return list(robots or [])


if __name__ == "__main__":
    sys.exit(run("drift", main))
