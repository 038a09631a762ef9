"""``qrobot doctor``: what this machine has, for a person and for a bug report."""

from __future__ import annotations

import sys

import click

from qrobot._json import json_text
from qrobot.cli.streams import say

__all__ = ["command"]


@click.command("doctor")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def command(as_json: bool) -> None:
    """Show versions, extras, which credentials are present, and folders.

    No credential is ever shown, only where it lies, and no network is asked. Exit code 0:
    no problem was found, 1: something hinders qRobot.

    \b
    Examples:
      qrobot doctor
      qrobot doctor --json
    """
    from qrobot.health.inventory import inventory, inventory_text
    from qrobot.jobs.redaction import redact

    data = inventory()
    text = json_text(data, indent=1) if as_json else inventory_text(data)
    say(redact(text))
    sys.exit(1 if data["problems"] else 0)
