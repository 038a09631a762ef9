"""ansible-playbook and play.py as `started` forks them: read with the settings, then run often."""

from __future__ import annotations

import atexit
import sys

import common
from ansible.cli.playbook import main
from ansible.utils.path import cleanup_tmp_file
from play import main as controller

__all__ = ["main", "play"]

# The end of a run would remove the folder with the modules that are packed for all runs.
atexit.unregister(cleanup_tmp_file)


def play() -> None:
    """Do what play.py does where it is a program."""
    sys.exit(common.run("play", controller))
