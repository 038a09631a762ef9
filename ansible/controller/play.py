"""Run a playbook of this checkout: its inventory is checked first, its exit code is told.

Usage: play.py provision [--inventory PATH] [--limit ROBOTS] [more for ansible-playbook]

`make` runs the playbooks by this program. make itself ends with 2 whatever happens; a program that
wants to tell the cases apart calls this one. Exit codes: 0 done, 1 the run could not begin or go
on, 2 a robot failed or the inventory cannot be used, 4 a robot did not answer (also when others
failed); more in docs/fleet.md.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
from pathlib import Path

from check_inventory import check
from common import ROOT, run, say

from qrobot._processes import catch_signals

FOLDER = ROOT / "ansible"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yml"))
MEANINGS = {
    1: "the run could not begin or go on; the reason stands above",
    2: "a robot failed, or ansible-playbook does not take these options; see above",
    4: "a robot did not answer, or a file of variables cannot be read; see above",
    5: "ansible-playbook does not take these options",
    99: "stopped by Ctrl-C; run it again to go on",
    250: "ansible-playbook ended by a fault of its own; see above",
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").splitlines()[0], allow_abbrev=False
    )
    parser.add_argument("playbook", choices=NAMES)
    parser.add_argument("-i", "--inventory", action="append", help="default: ansible/inventory")
    parser.add_argument("-l", "--limit", default="", help="robots or groups")
    given, more = parser.parse_known_args()
    sources = given.inventory or [str(FOLDER / "inventory")]
    os.environ["ANSIBLE_CONFIG"] = str(FOLDER / "ansible.cfg")
    check(sources, given.limit)
    command = [str(Path(sys.executable).parent / "ansible-playbook")]
    command += [word for source in sources for word in ("--inventory", source)]
    command += ["--limit", given.limit] if given.limit else []
    code = run_to_end([*command, *more, str(FOLDER / f"{given.playbook}.yml")])
    if code:
        say(f"{given.playbook}: exit code {code}: {MEANINGS.get(code, 'see above')}")
    raise SystemExit(code)


def run_to_end(command: list[str]) -> int:
    """Run a command to its end, hand on what ends it, and return its exit code."""
    child: subprocess.Popen[bytes] | None = None

    def pass_on(number: int) -> None:
        # The terminal sends Ctrl-C to the child too.
        if child is not None and number != signal.SIGINT:
            child.send_signal(number)

    with catch_signals(pass_on, "SIGINT", "SIGTERM", "SIGHUP"):
        child = subprocess.Popen(command)
        code = child.wait()
    return code if code >= 0 else 128 - code


if __name__ == "__main__":
    sys.exit(run("play", main))
