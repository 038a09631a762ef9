"""``qrobot health``: every stack computes something whose answer is known; reports of it.

``qrobot health NAMES...`` runs checks, ``qrobot health merge`` and ``compare`` read reports.
"""

from __future__ import annotations

import click

from qrobot.cli.health.reports import compare_, merge
from qrobot.cli.health.run import run

__all__ = ["command"]

RUN = "run"


class NamesOrCommand(click.Group):
    """Takes names of checks, unless the first word is a command's.

    A test holds that no check has the name of a command; whoever is in doubt writes ``--``
    before the names.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the word ``run`` before what does not begin with a command."""
        if not args or args[0] not in self.commands:
            args = [RUN, *args]
        return super().parse_args(ctx, args)


@click.group("health", cls=NamesOrCommand)
def command() -> None:
    """Prove that every installed stack computes right."""


for one in (run, compare_, merge):
    command.add_command(one)
