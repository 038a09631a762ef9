"""``qrobot health merge``: the reports of many machines beside each other."""

from __future__ import annotations

import sys

import click

from qrobot.cli.options import FILE, written
from qrobot.cli.streams import say, say_json

__all__ = ["merge"]


@click.command("merge")
@click.argument("files", nargs=-1, required=True, type=FILE)
@written("--html", "html_path", help="Write a page.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def merge(files: tuple[str, ...], html_path: str | None, as_json: bool) -> None:
    """Show which machine of a fleet differs, and in what.

    FILES are reports that qrobot health --output wrote, one a machine; of several of one machine
    the newest counts. Exit code 0: all machines are healthy, 1: one is not, 2: a file is not a
    report or the page cannot be written.

    \b
    Examples:
      qrobot health merge reports/*.json
      qrobot health merge reports/*.json --html fleet.html
    """
    from qrobot._files import write_text_atomic
    from qrobot.cli.health.show import show_fleet
    from qrobot.errors import InputError
    from qrobot.health import read_report
    from qrobot.health.reports import fleet, fleet_html
    from qrobot.report.outputs import check_outputs

    check_outputs([html_path] if html_path else [], files)
    found = fleet([read_report(path) for path in files])
    trouble = None
    if html_path:
        try:
            write_text_atomic(html_path, fleet_html(found))
        except InputError as error:  # a full disk; the terminal still has it
            trouble = error
    if as_json:
        say_json(found.to_dict())
    else:
        say(show_fleet(found))
    if trouble is not None:
        raise trouble
    sys.exit(1 if found.unhealthy else 0)
