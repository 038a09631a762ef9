"""Releases of qRobot on a robot: install, verify, switch, roll back, prune.

A release is a folder ``ROOT/releases/ID`` that is a Python environment of its own. It is complete
when ``manifest.json`` is in it, which is written last, after everything else is on the disk: a
power cut at any moment leaves a release that is complete or one that the next install wipes.
``ROOT/current`` names the release in use and is only ever replaced by one rename.

The folder that ``current`` names is never wiped, for services run from it and an environment cannot
be moved. When it is damaged, the same release is built again as ``ID.2`` (``ID.3``, ...);
``release.json`` in each holds the ID without that suffix.

Standard library only: this file is part of an Ansible module and, by itself, the program
``qrobot-release``.
"""

from .files import ReleaseError, read
from .releases import Releases

__all__ = ["ReleaseError", "Releases", "read"]
