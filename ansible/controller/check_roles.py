"""Check that every role owns what it has on a robot: its vars/owns.yml says all of it.

Usage: check_roles.py [FOLDER]       (make lint; FOLDER is the one of the playbooks)

What a role writes, starts or makes and does not own would be missing in the inventory, in drift and
in reset, in silence. Exit codes: 0 nothing is missing, 1 something is.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

PAGE = "docs/provisioning.md, 'Adding a role'"
TEXTS, LISTS = {"switch", "reset"}, {"needs", "tags", "files", "shared", "uncompared", "units",
                                    "users", "packages", "kernel_words", "steps"}  # fmt: skip
KEYS = TEXTS | LISTS | {"stays"}
PATHS = ("files", "shared", "stays", "uncompared")
# Modules that write a file, with the argument that names it.
WRITERS = {"blockinfile": "path", "copy": "dest", "get_url": "dest", "lineinfile": "path",
           "qrobot_token": "path", "qrobot_wheels": "dest", "template": "dest",
           "unarchive": "dest"}  # fmt: skip
UNIT = re.compile(r"/etc/systemd/system/([^/]+\.(?:service|socket|timer))")


class Role:
    """A role of a folder of playbooks, and what it says that it owns."""

    def __init__(self, folder: Path) -> None:
        self.name, self.folder = folder.name, folder
        self.path = folder / "vars" / "owns.yml"
        found = load(self.path) if self.path.is_file() else None
        key = f"{self.name}_owns"
        self.owns: dict[str, Any] | None = found.get(key) if isinstance(found, dict) else None

    def has(self, *keys: str) -> list[str]:
        return [entry for key in keys for entry in (self.owns or {}).get(key, [])]

    def tasks(self) -> Iterator[dict[str, Any]]:
        for kind in ("tasks", "handlers"):
            for path in sorted((self.folder / kind).glob("*.yml")):
                yield from each_task(load(path))


def faults(folder: Path) -> list[str]:
    """Return a sentence for everything that is wrong with the roles of a folder of playbooks."""
    roles = {path.name: Role(path) for path in sorted((folder / "roles").iterdir())}
    settings = load(folder / "roles/qrobot/defaults/main.yml")
    found = []
    for role in roles.values():
        if role.owns is None:
            found.append(f"{role.path}: there is no {role.name}_owns in it; see {PAGE}")
            continue
        found += [f"{role.path}: {fault}" for fault in form(role, roles, settings)]
        found += [f"{role.folder}: {fault}" for fault in owned(role, roles)]
    written = {path for role in roles.values() for task in role.tasks() for path in writes(task)}
    for role in roles.values():
        for path in role.has("files", "shared", "stays"):
            if path not in written and f"{Path(path).parent}/" not in written:
                found.append(f"{role.path}: no task writes {path}")
    return [*found, *unplayed(folder / "provision.yml", roles)]


def form(role: Role, roles: dict[str, Role], settings: dict[str, Any]) -> Iterator[str]:
    """Say what a role's facts have that nobody reads, or lack."""
    owns = role.owns or {}
    for key, value in owns.items():
        if key not in KEYS:
            yield f"'{key}' is not a key; use one of {', '.join(sorted(KEYS))}"
        elif key in LISTS and not isinstance(value, list) and "{{" not in str(value):
            yield f"{key} is not a list"
        elif key == "stays" and not isinstance(value, dict):
            yield "stays is not a dictionary from the file to why reset leaves it"
    if not isinstance(owns.get("tags"), list):
        yield "there are no tags: the name of the role is one"
    for name in role.has("needs"):
        if name not in roles:
            yield f"it needs '{name}', which is not a role"
    if owns.get("switch", "qrobot_boot") not in settings:
        yield f"its switch {owns['switch']} is not a setting of roles/qrobot/defaults/main.yml"
    for path in role.has("files"):
        unit = UNIT.fullmatch(path)
        if unit and unit[1] not in role.has("units"):
            yield f"{unit[1]} is not among its units"


def owned(role: Role, roles: dict[str, Role]) -> Iterator[str]:
    """Say what the tasks of a role write, start, make or install that it does not own."""
    places = role.has(*PATHS)
    folders = [path for one in with_needs(role, roles) for path in one.has("uncompared")]
    for task in role.tasks():
        name = f"task '{task.get('name')}'"
        for path in writes(task):
            if path not in places and not path.startswith(tuple(f"{one}/" for one in folders)):
                yield f"{name} writes {path}, which the role does not own"
        unit = module(task, "systemd_service")
        if unit.get("enabled") is True and unit["name"] not in role.has("units"):
            yield f"{name} enables {unit['name']}, which is not among its units"
        user = module(task, "user")
        if user.get("state") != "absent" and user and user["name"] not in role.has("users"):
            yield f"{name} makes the user {user['name']}, who is not among its users"
        if "name" in module(task, "apt"):
            yield f"{name} installs packages; base does that: name them in vars/owns.yml"


def with_needs(role: Role, roles: dict[str, Role]) -> list[Role]:
    """Return a role and those that it needs, and those that they need."""
    needs = [roles[name] for name in role.has("needs") if name in roles]
    return [role, *(one for need in needs for one in with_needs(need, roles))]


def unplayed(path: Path, roles: dict[str, Role]) -> Iterator[str]:
    """Say which roles the playbook does not play, or by other tags or another switch."""
    (play,) = load(path)
    played = {entry["role"]: entry for entry in play["roles"]}
    for entry in play["pre_tasks"]:
        played[entry["ansible.builtin.import_role"]["name"]] = entry
    for name in roles.keys() - played.keys() - {"reset"}:
        yield f"{path}: the role {name} is not there"
    for name, entry in played.items():
        if entry.get("tags") != f"{{{{ provision_tags.{name} }}}}":
            yield f"{path}: the tags of {name} are not '{{{{ provision_tags.{name} }}}}'"
        owns = roles[name].owns if name in roles else None
        switch = (owns or {}).get("switch")
        if entry.get("when") != (f"{switch} | bool" if switch else None):
            yield f"{path}: {name} is not switched by the switch in its vars/owns.yml"


def writes(task: dict[str, Any]) -> Iterator[str]:
    """Return the files that a task writes on the robot; one that ends with / holds them."""
    places = [module(task, name).get(argument, "") for name, argument in WRITERS.items()]
    file = module(task, "file")
    if file.get("state") in ("link", "hard", "touch"):
        places.append(file.get("path") or file.get("dest", ""))
    loop = task.get("loop")
    for place in filter(None, places) if "delegate_to" not in task else ():
        for item in loop if isinstance(loop, list) else [None]:
            yield place.replace("{{ item }}", str(item)) if isinstance(item, str) else place


def module(task: dict[str, Any], name: str) -> dict[str, Any]:
    """Return the arguments of a task of this module; none where it is one of another."""
    for spelled in (f"ansible.builtin.{name}", f"ansible.legacy.{name}", name):
        if isinstance(task.get(spelled), dict):
            return dict(task[spelled])
    return {}


def each_task(steps: Any) -> Iterator[dict[str, Any]]:
    """Return every task of a list, those of blocks too."""
    for step in steps or []:
        yield step
        for key in ("block", "rescue", "always"):
            yield from each_task(step.get(key))


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text())


def main() -> int:
    folder = Path(sys.argv[1]) if sys.argv[1:] else Path(__file__).resolve().parents[1]
    found = faults(folder)
    for fault in found:
        print(fault, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
