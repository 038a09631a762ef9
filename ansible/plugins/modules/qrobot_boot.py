#!/usr/bin/python
"""config.txt and cmdline.txt of a Raspberry Pi: a power cut leaves the old or the new file."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_boot
short_description: Sets lines of config.txt and words of cmdline.txt
description:
  - cmdline.txt is one line of words. A word C(name=value) that is there with another value is
    replaced; what is not asked for stays as it is. Several values of one name, as C(console) has
    them, are kept.
  - config.txt has sections. The lines asked for are kept in one block under C([all]), which is
    added at the end, so they count for every board; lines outside the block are never touched.
  - Each file is written aside, synced and renamed, and the first version that was found is kept
    beside it as C(FILE.before-qrobot).
options:
  folder:
    description: The boot partition, /boot/firmware since bookworm, /boot before.
    type: path
    required: true
  cmdline:
    description: Words that the kernel's command line must have.
    type: list
    elements: str
    default: []
  config:
    description: Lines that config.txt must have.
    type: list
    elements: str
    default: []
  state:
    description: >-
      C(absent) takes the words and the block out again, but for the words that the first version
      has, and removes the copies of the first versions.
    type: str
    choices: [present, absent]
    default: present
author: The qRobot authors
"""

EXAMPLES = r"""
- name: Let the kernel count the memory of services
  qrobot_boot:
    folder: /boot/firmware
    cmdline: [cgroup_enable=memory]
    config: [dtparam=watchdog=on]
"""

RETURN = r"""
files:
  description: Names of the files that changed, or would change in check mode.
  returned: always
  type: list
"""

import contextlib
import os
import re
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule

BEGIN = "# --- qRobot: begin ---"
END = "# --- qRobot: end ---"
BLOCK = re.compile(rf"\n?{re.escape(BEGIN)}\r?\n.*?{re.escape(END)}\r?\n?", re.DOTALL)
SECTION = re.compile(r"\s*\[.*\]\s*")
SEVERAL = ("console", "cgroup_enable", "cgroup_disable")
"""Names that the kernel takes several times, with one value each."""


class FaultError(Exception):
    """Something that stops the module; the text is one sentence with the advice."""


def cmdline_with(text, words, present=True):
    """Return a kernel command line that has the words, or has them no more.

    A file of several lines is an error of its writer: the firmware reads the first one only.
    """
    lines = [line for line in text.splitlines() if line.strip()]
    found = lines[0].split() if lines else []
    for word in words:
        name, equals, _ = word.partition("=")
        if not present:
            found = [one for one in found if one != word]
        elif word not in found:
            if equals and name not in SEVERAL:
                found = [one for one in found if not one.startswith(name + "=")]
            found.append(word)
    return " ".join(found) + "\n"


def config_with(text, lines, present=True):
    """Return a config.txt whose block has the lines, or is gone.

    A new block goes to the end; one that is there stays in its place, since what others append
    after it counts under its C([all]).
    """
    found = BLOCK.search(text)
    if not found and not (present and lines):
        return text
    before, after = (text[: found.start()], text[found.end() :]) if found else (text, "")
    before = before.rstrip("\n") + "\n" if before.strip("\n") else ""
    if present and lines:
        block = "\n".join([BEGIN, "[all]", *lines, END])
        return f"{before}\n{block}\n{after}" if before else f"{block}\n{after}"
    return before + ("[all]\n" if _needs_all(before, after) else "") + after


def _needs_all(before, after):
    """Return whether lines after the block would fall into a section that begins before it."""
    sections = [line.strip() for line in before.splitlines() if SECTION.fullmatch(line)]
    said = [line for line in after.splitlines() if line.strip() and line.strip()[0] != "#"]
    return bool(sections[-1:] not in ([], ["[all]"]) and said and not SECTION.fullmatch(said[0]))


def backup(path):
    """Return where the first version of a boot file that was found is kept."""
    return path.with_name(path.name + ".before-qrobot")


def added_words(words, path):
    """Return the words that the first version of cmdline.txt did not have; none without a copy."""
    try:
        before = backup(path).read_bytes().decode("utf-8", errors="replace").split()
    except OSError:
        return []
    return [word for word in words if word not in before]


def write(path, text):
    """Replace a boot file by another text; the first one that was found is kept beside it."""
    before = backup(path)
    if not before.exists() or not before.stat().st_size:  # a cut may leave its name only
        replace(before, path.read_bytes())
    replace(path, text.encode("utf-8", errors="surrogateescape"))


def replace(path, data):
    """Replace a file so that a power cut on FAT, which has no journal, leaves the old or the new.

    A rename there leaves size and place of the file to its inode, which is written later, while
    the clusters of the old file are freed at once: cut between, the name has neither. So everything
    is synced, and the old file is held open until then, which keeps its clusters.
    """
    aside = path.with_name(path.name + ".new")
    with contextlib.ExitStack() as held:
        if path.exists():
            held.enter_context(open(path, "rb"))
        with open(aside, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.sync()
        aside.replace(path)
        os.sync()


def of_cmdline(folder, words, present):
    """Return what changes in cmdline.txt: its path, its text and the new one; None for nothing.

    A file that says the same is left, however its spaces are.
    """
    path = folder / "cmdline.txt"
    if not path.exists():
        return None  # only config.txt makes a boot partition
    text = read(path)
    if not text.strip():
        raise FaultError(f"{path} is empty: restore it from {path}.before-qrobot or the image")
    new = cmdline_with(text, words if present else added_words(words, path), present)
    return None if new.split() == text.split() else (path, text, new)


def of_config(folder, lines, present):
    """Return what changes in config.txt, as C(of_cmdline) does."""
    path = folder / "config.txt"
    text = read(path)
    new = config_with(text, lines, present)
    return None if new == text else (path, text, new)


def read(path):
    try:
        return path.read_bytes().decode("utf-8", errors="surrogateescape")
    except OSError as error:
        raise FaultError(f"{path}: {error.strerror}: mount the boot partition there") from None


def apply(changes, copies):
    """Write the files that change, and remove the copies that are needed no more."""
    for path, _, new in changes:
        try:
            write(path, new)
        except OSError as error:
            raise FaultError(f"{path}: {error.strerror}; the file is as it was") from None
    for path in copies:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise FaultError(f"{path}: {error.strerror}: remove it") from None


def main():
    module = AnsibleModule(
        argument_spec={
            "folder": {"type": "path", "required": True},
            "cmdline": {"type": "list", "elements": "str", "default": []},
            "config": {"type": "list", "elements": "str", "default": []},
            "state": {"type": "str", "choices": ["present", "absent"], "default": "present"},
        },
        supports_check_mode=True,
    )
    given = module.params
    folder = Path(given["folder"])
    for word in given["cmdline"]:
        if not word or re.search(r"\s", word):
            module.fail_json(msg=f"cmdline: {word!r} is not one word: give each word by itself")
    present = given["state"] == "present"
    copies = [] if present else [backup(folder / name) for name in ("cmdline.txt", "config.txt")]
    stale = any(path.exists() for path in copies)
    try:
        changes = [change for change in (of_cmdline(folder, given["cmdline"], present),
                                         of_config(folder, given["config"], present))
                   if change]  # fmt: skip
        if not module.check_mode:
            apply(changes, copies)
    except FaultError as fault:
        module.fail_json(msg=str(fault))
    diff = [
        {"before_header": str(path), "after_header": str(path), "before": text, "after": new}
        for path, text, new in changes
    ]
    names = [path.name for path, _, _ in changes]
    module.exit_json(changed=stale or bool(changes), files=names, diff=diff)


if __name__ == "__main__":
    main()
