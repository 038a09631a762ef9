"""The recipe of an Ansible role, followed from the page in a copy of the playbooks."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from fleet_house import ANSIBLE

PAGE = ANSIBLE.parent / "docs/extending.md"


def follow(folder: Path) -> Path:
    """Copy the checkout's playbooks and do what the page says; returns their folder."""
    made = folder / "ansible"
    left = shutil.ignore_patterns("__pycache__", ".ansible", "inventory")
    shutil.copytree(ANSIBLE, made, ignore=left)
    for name in ("qrobot", "docker", "locks"):  # what the controller's programs import and read
        (folder / name).symlink_to(ANSIBLE.parent / name)
    recipe = PAGE.read_text().partition("\n## An Ansible role\n")[2].partition("\n## ")[0]
    for text in re.findall(r"```yaml\n(.*?)```\n", recipe, re.DOTALL):
        if new := re.match(r"---\n# (ansible/\S+)\n", text):
            path = folder / new[1]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            continue
        where, _, added = text.partition("\n")
        place = re.fullmatch(r"# at the end of (?:the (roles) in )?(ansible/\S+)", where)
        assert place, where
        before = (folder / place[2]).read_text()
        end = before.index("  post_tasks:") if place[1] else len(before)
        (folder / place[2]).write_text(before[:end] + added + before[end:])
    return made
