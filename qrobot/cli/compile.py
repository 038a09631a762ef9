"""``qrobot compile``: make the machine code of the searches, once."""

from __future__ import annotations

from pathlib import Path

import click

from qrobot.cli.streams import show

__all__ = ["command"]


@click.command("compile")
@click.option(
    "--from",
    "older",
    metavar="FOLDER",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Package folder of another installation: what it has of unchanged searches is copied.",
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def command(older: Path | None, as_json: bool) -> None:
    """Compile the searches for this machine, so that no plan waits for it.

    Takes half a minute of one x86-64 core, and a second when it was done before. The machine
    code is kept in numba's cache: beside the package, or in the user's cache folder, or where
    NUMBA_CACHE_DIR says. What the owner of an installation compiles beside the package is
    used by all.

    \b
    Examples:
      qrobot compile
      NUMBA_CACHE_DIR=/var/cache/qrobot qrobot compile
    """
    from qrobot import _jit
    from qrobot.backends.classical.compilation import compile_searches

    _jit.older = older
    seconds = compile_searches()
    show(f"compiled in {seconds:.1f} s", {"seconds": round(seconds, 1)}, as_json)
