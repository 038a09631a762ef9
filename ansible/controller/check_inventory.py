"""Check an inventory before a playbook reads it: one sentence where it cannot be used.

ansible.cfg and the callback qrobot_outcome refuse the same in a playbook that is run without
play.py, in Ansible's words.
"""

from __future__ import annotations

import contextlib
import difflib
import io
import re
from collections.abc import Iterator
from pathlib import Path

import yaml

from qrobot.errors import InputError

__all__ = ["check"]

COPY = "cp -r ansible/inventory.example ansible/inventory and name your robots in its hosts.yml"
VAULT = "$ANSIBLE_VAULT"
YAML = {".yml", ".yaml", ".json"}


def check(sources: list[str], limit: str) -> None:
    """Refuse inventories that cannot be read or name no robot, and a limit that names none.

    Raises
    ------
    InputError
        With the file, and the line and the column where there are some.
    """
    for source in sources:
        if "," in source:  # a list of hosts
            continue
        if not Path(source).exists():
            raise InputError("no such inventory", source=source, advice=COPY)
        for path in files(Path(source)):
            check_syntax(path)
    check_robots(sources, limit)


def files(top: Path) -> Iterator[Path]:
    """Return the YAML files of an inventory, those of its variables too."""
    for path in sorted(top.rglob("*")) if top.is_dir() else [top]:
        if path.suffix in YAML and path.is_file():
            yield path


def check_syntax(path: Path) -> None:
    """Refuse a file that is not YAML, with the line and the column."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte {error.start + 1} is not UTF-8", source=str(path), advice="save it as UTF-8"
        ) from None
    if text.startswith(VAULT):
        return
    try:
        for _ in yaml.compose_all(text, Loader=yaml.SafeLoader):
            pass
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}" if mark else None
        told = error.problem or error.context or "it is not YAML"
        raise InputError(
            told, source=str(path), field=place, advice="advice the YAML there or just above"
        ) from None
    except yaml.YAMLError as error:
        raise InputError(" ".join(str(error).split()), source=str(path)) from None


def check_robots(sources: list[str], limit: str) -> None:
    """Refuse an inventory without robots, and a limit that names none."""
    from ansible.errors import AnsibleError
    from ansible.inventory.manager import InventoryManager, split_host_pattern
    from ansible.parsing.dataloader import DataLoader

    source = ", ".join(sources)
    told = io.StringIO()
    try:
        with contextlib.redirect_stderr(told):  # what each of Ansible's plugins says, in lines
            inventory = InventoryManager(loader=DataLoader(), sources=sources)
    except AnsibleError as error:
        if "vault" in str(error).lower():  # the playbook is given the password, this program is not
            return
        why = " ".join(str(error).split())
        file = re.search(r"inventory source (\S+)$", why)
        shape = re.search(r"with 'yaml' plugin: (.+?)(?:, got: .*)?$", told.getvalue(), re.M)
        raise InputError(
            f"it cannot be read ({shape[1] if shape else why})",
            source=file[1] if file else source,
            advice="give an inventory as ansible/inventory.example has it",
        ) from None
    if not inventory.list_hosts("all"):
        raise InputError(
            "it names no robot", source=source, advice="name your robots in its hosts.yml"
        )
    robots = [str(host) for host in inventory.list_hosts("all")]
    for part in split_host_pattern(limit) if limit else []:
        name = part.lstrip("!&")
        try:
            found = name.startswith("@") or bool(inventory.get_hosts(name))
        except AnsibleError:
            found = False
        if not found:
            near = difflib.get_close_matches(name, [*robots, *inventory.groups], n=1)
            known = ", ".join(robots[:5]) + (", .." if len(robots) > 5 else "")
            raise InputError(
                f"'{name}' is not a robot or a group of {source}",
                field="LIMIT",
                advice=f"did you mean '{near[0]}'?" if near else f"it has {known}",
            )
    if limit:
        inventory.subset(limit)
        if not inventory.list_hosts("all"):
            raise InputError(f"'{limit}' leaves no robot of {source}", field="LIMIT")
