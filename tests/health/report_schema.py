"""The JSON Schema of a report, made from its classes.

``PYTHONPATH=tests python -m health.report_schema > qrobot/health/report.schema.json`` writes it.
"""

from __future__ import annotations

import sys
from typing import Any

from pydantic import TypeAdapter

from qrobot._json import json_text
from qrobot.health.model import SCHEMA, Report

COUNTED = ("pass", "fail", "error", "absent", "good", "warning", "fault", "unknown")


def json_schema() -> dict[str, Any]:
    """Return the schema as the model gives it; a reader must bear fields that it does not list."""
    made: dict[str, Any] = TypeAdapter(Report).json_schema(mode="serialization")
    count = {"type": "integer", "minimum": 0}
    made["properties"] = {
        "schema": {"const": SCHEMA},
        **made["properties"],
        "healthy": {"type": "boolean", "description": "No check is bad, no finding a fault."},
        "totals": {
            "type": "object",
            "description": "How many checks and findings there are of each status.",
            "properties": dict.fromkeys(COUNTED, count),
            "required": list(COUNTED),
        },
    }
    made["properties"]["made"]["format"] = "date-time"
    for one in (made, *made["$defs"].values()):
        one["required"] = list(one["properties"])  # whoever writes gives all of them
        one["description"] = one["description"].partition("\n")[0]
        for about in one["properties"].values():
            about.pop("default", None)
            about.pop("title", None)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:{SCHEMA.replace('.', ':').replace('/', ':')}",
        **made,
        "title": "What qrobot health found",
    }


if __name__ == "__main__":
    sys.stdout.write(json_text(json_schema(), indent=1) + "\n")
