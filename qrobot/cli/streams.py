"""Output streams whose reader may have gone away, as ``qrobot ... | head`` does it."""

from __future__ import annotations

import os
import sys
from typing import TextIO

import click

__all__ = ["drop", "say"]


def say(text: str, *, err: bool = False) -> None:
    """Print a text; a reader that went away keeps nobody from going on.

    For commands whose exit code must be told whether anybody reads or not.
    """
    try:
        click.echo(text, err=err)
    except BrokenPipeError:
        drop(sys.stderr if err else sys.stdout)


def drop(stream: TextIO) -> None:
    """Send what is still buffered nowhere: it must not raise again when Python ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
