"""``qrobot backends``: what there is."""

from __future__ import annotations

import click

from qrobot.cli.streams import show

__all__ = ["command"]


@click.command("backends")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def command(as_json: bool) -> None:
    """List the backends: what they can do and how to install them.

    \b
    Examples:
      qrobot backends
      qrobot backends --json
    """
    from qrobot.report.tables import backend_rows, backend_table

    rows = backend_rows()
    show(backend_table(rows), rows, as_json)
