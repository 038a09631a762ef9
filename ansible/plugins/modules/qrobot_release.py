#!/usr/bin/python
"""Releases of qRobot on a robot, as a module."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_release
short_description: Installs, verifies, switches, rolls back and prunes releases of qRobot
description:
  - A release is a folder C(ROOT/releases/ID) with an environment of its own. It is complete or it
    is not there.
  - C(ROOT/current) names the release in use and is replaced by one rename.
  - The folder in use is never wiped. When it is damaged, the same release is built again as
    C(ID.2); the result's
    RV(id) is the name to use from then on.
options:
  root:
    description: Folder of the releases.
    type: path
    default: /opt/qrobot
  state:
    description:
      - V(present) installs a release from wheels on the robot, without switching to it.
      - V(current) switches to an installed release. Give the RV(id) that V(present) returned.
      - V(absent) removes a release that is not in use, such as one that failed its health checks.
      - V(pruned) removes old releases, unfinished folders and wheels that nothing needs.
      - V(rolled_back) switches to the release that was in use before; a damaged one is passed over.
      - V(verified) fails when a file of a release is missing or changed (without O(id), of the one
        in use).
      - V(status) tells what is there; with O(id) it returns the name of its complete release, or
        null.
      - V(reset) removes everything under O(root), and refuses when something foreign is there.
    choices: [present, current, absent, pruned, rolled_back, verified, status, reset]
    default: status
    type: str
  id:
    description: The release. Needed for V(present), V(current) and V(absent).
    type: str
  requirements:
    description: For V(present). Text of the lock, each package with its version and hashes.
    type: str
  wheels:
    description: For V(present). Folder of the wheels on the robot; C(ROOT/wheels) if not given.
    type: path
  uv:
    description: For V(present). The installer on the robot; C(ROOT/bin/uv) if not given.
    type: path
  python:
    description: For V(present). The interpreter that the environment is made from.
    type: path
    default: /usr/bin/python3
  note:
    description: For V(present). What to remember in C(release.json).
    type: dict
    default: {}
  need_mb:
    description: For V(present). Room that the release takes; nothing is unpacked when it is not
      there.
    type: int
    default: 0
  keep_free_mb:
    description: For V(present). Room that must be free afterwards.
    type: int
    default: 0
  compiles:
    description: For V(present). Whether the searches are compiled when the release is made.
    type: bool
    default: true
  keep:
    description: For V(pruned). How many releases stay; the current and the previous one always do.
    type: int
    default: 3
  verify:
    description: For V(present), build a release again that is damaged. For V(status), tell which
      are.
    type: bool
    default: false
author: The qRobot authors
attributes:
  check_mode:
    support: full
  diff_mode:
    support: full
"""

EXAMPLES = r"""
- name: Install the release
  qrobot_release:
    state: present
    id: 1.0-edge-3f2a9c
    requirements: "{{ lookup('file', 'edge.txt') }}"
    need_mb: 1800
    keep_free_mb: 500
    verify: true
  register: release

- name: Use it
  qrobot_release:
    state: current
    id: "{{ release.id }}"

- name: Keep three
  qrobot_release:
    state: pruned
    keep: 3
"""

RETURN = r"""
id:
  description: Name of the release that this is about; not always the O(id) given. Null when there
    is none.
  returned: always
  type: str
path:
  description: Its folder.
  returned: always
  type: str
current:
  description: The release in use, or null.
  returned: always
  type: str
previous:
  description: The release that a rollback goes to, or null.
  returned: always
  type: str
releases:
  description: All of them, newest first, each with C(id), C(base), C(complete), C(size_mb),
    C(installed_at), C(note).
  returned: always
  type: list
  elements: dict
free_mb:
  description: Room on the disk.
  returned: always
  type: int
damage:
  description: What differs from the manifest, the first 20 differences.
  returned: for V(verified)
  type: list
  elements: str
uncompiled:
  description: Why its searches were not compiled, empty when they were or need not be.
  returned: for V(present)
  type: str
removed:
  description: What was removed, as paths below the root.
  returned: for V(pruned)
  type: list
  elements: str
"""

from pathlib import Path

from ansible.module_utils.basic import AnsibleModule
from ansible.module_utils.qrobot_release import ReleaseError, Releases


def verified(releases, name, check):
    """Name and differences of a release; fails when there are any."""
    name = name or releases.current_id()
    if name is None or (check and not (releases.folder / name).is_dir()):
        if check:  # on a bare machine, what would be verified is not there yet
            return {"id": name, "damage": [], "changed": False}
        raise ReleaseError(f"no release is in use under {releases.root}")
    found = releases.verify(name)
    if found["count"]:
        rest = "" if found["count"] == 1 else f" and {found['count'] - 1} more"
        problem = f"the release {name} is damaged: {found['differences'][0]}{rest}"
        raise ReleaseError(problem + "; provision again to rebuild it")
    return {"id": name, "damage": [], "changed": False}


def apply(releases, given, check):
    """Do what the state asks; returns the part of the result that belongs to it."""
    state, name = given["state"], given["id"]
    if state == "present":
        name, changed = releases.install(
            name,
            given["requirements"],
            given["wheels"] or releases.root / "wheels",
            given["uv"] or releases.root / "bin" / "uv",
            given["python"],
            given["note"],
            given["need_mb"],
            given["keep_free_mb"],
            given["verify"],
            given["compiles"],
        )
        return {"id": name, "changed": changed, "uncompiled": releases.uncompiled(name)}
    if state == "current":
        return {"id": name, "changed": releases.switch(name)}
    if state == "absent":
        return {"id": name, "changed": releases.discard(name)}
    if state == "pruned":
        removed = releases.prune(given["keep"])
        return {"id": releases.current_id(), "removed": removed, "changed": bool(removed)}
    if state == "rolled_back":
        return {"id": releases.rollback(), "changed": True}
    if state == "verified":
        return verified(releases, name, check)
    if state == "reset":
        return {"id": None, "changed": releases.reset()}
    if name:
        return {"id": releases.complete_id_for(name, verify=given["verify"]), "changed": False}
    return {"id": releases.current_id(), "changed": False}


def outline(status):
    """Return what the diff shows of a status."""
    names = sorted(r["id"] + ("" if r["complete"] else " (unfinished)") for r in status["releases"])
    return {"current": status["current"], "releases": names}


def predict(before, result, state):
    """Outline after a run in check mode."""
    after = dict(before, releases=list(before["releases"]))
    if not result["changed"]:
        return after
    if state == "reset":
        return {"current": None, "releases": []}
    if state == "present":
        after["releases"] = sorted({*after["releases"], result["id"]})
    elif state in ("current", "rolled_back"):
        after["current"] = result["id"]
    else:
        gone = {result["id"]} if state == "absent" else {Path(p).name for p in result["removed"]}
        after["releases"] = [n for n in after["releases"] if n.split(" ")[0] not in gone]
    return after


def main():
    """Run the module."""
    module = AnsibleModule(
        argument_spec={
            "root": {"type": "path", "default": "/opt/qrobot"},
            "state": {
                "default": "status",
                "choices": [
                    "present",
                    "current",
                    "absent",
                    "pruned",
                    "rolled_back",
                    "verified",
                    "status",
                    "reset",
                ],
            },
            "id": {"type": "str"},
            "requirements": {"type": "str"},
            "wheels": {"type": "path"},
            "uv": {"type": "path"},
            "python": {"type": "path", "default": "/usr/bin/python3"},
            "note": {"type": "dict", "default": {}},
            "need_mb": {"type": "int", "default": 0},
            "keep_free_mb": {"type": "int", "default": 0},
            "compiles": {"type": "bool", "default": True},
            "keep": {"type": "int", "default": 3},
            "verify": {"type": "bool", "default": False},
        },
        required_if=[
            ("state", "present", ["id", "requirements"]),
            ("state", "current", ["id"]),
            ("state", "absent", ["id"]),
        ],
        supports_check_mode=True,
    )
    given, check = module.params, module.check_mode
    releases = Releases(given["root"], dry=check)
    before = outline(releases.status())
    try:
        result = apply(releases, given, check)
        status = releases.status(
            verify=given["state"] == "status" and given["verify"] and not given["id"]
        )
    except ReleaseError as error:
        module.fail_json(msg=str(error))
    except OSError as error:
        module.fail_json(msg=f"{error.filename or given['root']}: {error.strerror}")
    after = predict(before, result, given["state"]) if check else outline(status)
    path = str(releases.folder / result["id"]) if result["id"] else None
    module.exit_json(**status, **result, path=path, diff={"before": before, "after": after})


if __name__ == "__main__":
    main()
