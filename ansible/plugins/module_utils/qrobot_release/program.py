"""The program ``qrobot-release`` for the person at the robot."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from .files import ReleaseError
from .releases import Releases

EXAMPLES = """examples:
  qrobot-release list                    releases, the one in use and the one before it
  qrobot-release verify                  is any file of the release in use missing or changed?
  sudo qrobot-release rollback           back to the release before
  sudo qrobot-release switch 1.0-edge-3f2a9c
  sudo qrobot-release prune --keep 2     remove older releases and their wheels

exit codes: 0 done, 1 damaged or nothing to go back to, 2 bad input
After rollback or switch, restart what runs: sudo systemctl restart 'qrobot*'
"""


def as_table(state: dict[str, Any]) -> str:
    """Releases as lines of text."""
    lines = []
    for release in state["releases"]:
        use = {state["current"]: "in use", state["previous"]: "before"}.get(release["id"], "")
        whole = f"{release['size_mb']} MB" if release["complete"] else "unfinished"
        when = release["installed_at"] or "-"
        lines.append(f"{use:8}{release['id']:40}{whole:>12}  {when}".rstrip())
    return "\n".join([*(lines or ["no releases"]), f"{state['free_mb']} MB are free"])


def main(arguments: list[str] | None = None) -> int:
    """Run the program for the person at the robot; returns its exit code."""
    parser = argparse.ArgumentParser(
        prog="qrobot-release",
        description="Releases of qRobot on this robot.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--json", action="store_true", help="answer as JSON")
    common.add_argument("--root", default="/opt/qrobot", help="default: %(default)s")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("list", parents=[common], help="releases, newest first")
    verify = commands.add_parser("verify", parents=[common], help="compare with the manifest")
    verify.add_argument("id", nargs="?", help="default: the one in use")
    commands.add_parser("rollback", parents=[common], help="go back to the release before")
    switch = commands.add_parser("switch", parents=[common], help="use another release")
    switch.add_argument("id")
    prune = commands.add_parser("prune", parents=[common], help="remove old releases and wheels")
    prune.add_argument("--keep", type=int, default=3, help="how many stay (default: %(default)s)")
    given = parser.parse_args(arguments)
    try:
        answer, text, code = _run(Releases(given.root), given)
    except ReleaseError as error:
        answer, text, code = {"error": str(error)}, f"qrobot-release: {error}", error.code
    except OSError as error:
        problem = f"cannot read {error.filename or given.root}: {error.strerror}"
        answer, text, code = {"error": problem}, f"qrobot-release: {problem}", 1
    out = sys.stderr if "error" in answer and not given.json else sys.stdout
    out.write((json.dumps(answer, indent=2) if given.json else text) + "\n")
    return code


def _run(releases: Releases, given: Any) -> tuple[dict[str, Any], str, int]:
    """Answer, its text and the exit code of one command."""
    if given.command == "list":
        state = releases.status()
        return state, as_table(state), 0
    if given.command == "verify":
        name = given.id or releases.current_id()
        if name is None:
            raise ReleaseError(f"no release is in use under {releases.root}: name one by its ID")
        found = releases.verify(name)
        more = found["count"] - len(found["differences"])
        lines = [*found["differences"], *([f"and {more} more"] if more else [])]
        text = "\n".join(lines) or f"{name}: every file is as installed"
        return {"id": name, **found}, text, int(found["count"] > 0)
    if given.command == "prune":
        removed = releases.prune(given.keep)
        return {"removed": removed}, "\n".join(removed) or "nothing to remove", 0
    changed = True
    if given.command == "rollback":
        name = releases.rollback()
    else:
        name, changed = given.id, releases.switch(given.id)
    return {"current": name, "changed": changed}, f"in use: {name}", 0
