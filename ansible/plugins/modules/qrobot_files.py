#!/usr/bin/python
"""Folders and files below a folder of a user, made and removed as that user."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_files
short_description: Folders and files below a folder of a user, made and removed as that user
description:
  - A process of its own becomes the owner of O(folder) before anything below it is looked at, and
    follows no link there. A link on the way is refused with one sentence; root is never led
    elsewhere.
  - Files are written aside, synced and renamed, with the mode 0600; folders have the mode 0700.
options:
  folder:
    description: The user's folder. It must be there, but in check mode.
    type: path
    required: true
  owner:
    description: Who must own it.
    type: str
    required: true
  folders:
    description: Folders below it that must be there.
    type: list
    elements: str
    default: []
  files:
    description: Files below it that must have a content.
    type: list
    elements: dict
    default: []
    suboptions:
      path:
        description: Path from O(folder).
        type: str
        required: true
      content:
        description: The text.
        type: str
        required: true
  absent:
    description: Files and links below it that must not be there.
    type: list
    elements: str
    default: []
  plain:
    description: Names below it that are refused where they are there and no plain file, before
      anything is done; so a task whose output is hidden finds nothing to refuse.
    type: list
    elements: str
    default: []
  closed:
    description: Files below it that get the mode 0600 where they are there; links are passed over.
    type: list
    elements: str
    default: []
author: The qRobot authors
attributes:
  check_mode:
    support: full
"""

EXAMPLES = r"""
- name: Write a token
  qrobot_files:
    folder: /var/lib/qrobot
    owner: qrobot
    folders: [.config/dwave]
    files:
      - path: .config/dwave/dwave.conf
        content: "{{ text }}"
  no_log: true
"""

RETURN = r"""
paths:
  description: What changed, or would change in check mode, as paths below the folder.
  returned: always
  type: list
  elements: str
"""

import contextlib
import os
import stat

from ansible.module_utils.basic import AnsibleModule
from ansible.module_utils.qrobot_owned import NotOwnedError, OwnedError, as_owner, split


def ensure_folder(home, name, check):
    """Make a folder, and close it and those on its way; tell whether that changed anything."""
    changed = False
    for end in range(name.count("/") + 1):
        part = "/".join(name.split("/")[: end + 1])
        handle = home.folder(part)
        if handle is None:
            changed = True
            if check:
                break
            handle = home.folder(part, make=True)
        changed |= set_mode(handle, 0o700, check)
        os.close(handle)
    return changed


def set_mode(handle, mode, check):
    """Set the mode of what is open; tell whether it was another one."""
    if stat.S_IMODE(os.fstat(handle).st_mode) == mode:
        return False
    if not check:
        os.fchmod(handle, mode)
    return True


def ensure_file(home, name, content, check):
    """Write a file that has another content or mode; tell whether it had."""
    data = content.encode()
    if is_same(home, name, data):
        return False
    if check:
        return True
    folder, last = split(name)
    handle = home.folder(folder, make=True)
    aside = f".{last}.qrobot-new"
    try:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(aside, dir_fd=handle)  # of a run that was cut off
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        with os.fdopen(os.open(aside, flags, 0o600, dir_fd=handle), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(aside, last, src_dir_fd=handle, dst_dir_fd=handle)
        os.fsync(handle)
    finally:
        os.close(handle)
    return True


def is_same(home, name, data):
    """Tell whether a file is the owner's, closed to others, and has this content already."""
    if refuse_other(home, name) == "absent":
        return False
    try:
        handle = home.file(name)
    except OwnedError:
        return False  # somebody else's: it is replaced
    if handle is None:
        return False
    with os.fdopen(handle, "rb") as file:
        found = os.fstat(handle)
        if (found.st_uid, stat.S_IMODE(found.st_mode)) != (os.geteuid(), 0o600):
            return False
        return file.read(len(data) + 1) == data


def refuse_other(home, name):
    """Refuse a name that is neither free nor a plain file's; tell which of both it is."""
    kind = home.kind(name)
    if kind == "link":
        home.file(name)  # says so
    if kind not in ("absent", "file"):
        raise OwnedError(f"{home.path}/{name} is not a plain file: remove it and run again")
    return kind


def ensure_absent(home, name, check):
    """Remove a file or a link; tell whether one was there."""
    kind = home.kind(name)
    if kind == "absent":
        return False
    if kind == "folder":
        raise OwnedError(f"{home.path}/{name} is a folder where a file should be: remove it")
    if not check:
        folder, last = split(name)
        handle = home.folder(folder)
        try:
            os.unlink(last, dir_fd=handle)
        finally:
            os.close(handle)
    return True


def ensure_closed(home, name, check):
    """Close a file to others; a link is not a file of ours, and what it leads to is not either."""
    try:
        handle = home.file(name)
    except OwnedError:
        return False
    if handle is None:
        return False
    try:
        return os.fstat(handle).st_uid == os.geteuid() and set_mode(handle, 0o600, check)
    finally:
        os.close(handle)


def apply(home, given, check):
    """Do what is asked; the paths that changed."""
    for name in given["plain"]:
        refuse_other(home, name)
    changed = [name for name in given["absent"] if ensure_absent(home, name, check)]
    changed += [name for name in given["folders"] if ensure_folder(home, name, check)]
    for entry in given["files"]:
        if ensure_file(home, entry["path"], entry["content"], check):
            changed.append(entry["path"])
    changed += [name for name in given["closed"] if ensure_closed(home, name, check)]
    return changed


def main():
    strings = {"type": "list", "elements": "str", "default": []}
    module = AnsibleModule(
        argument_spec={
            "folder": {"type": "path", "required": True},
            "owner": {"type": "str", "required": True},
            "folders": strings,
            "files": {
                "type": "list",
                "elements": "dict",
                "default": [],
                "options": {
                    "path": {"type": "str", "required": True},
                    "content": {"type": "str", "required": True, "no_log": True},
                },
            },
            "absent": strings,
            "plain": strings,
            "closed": strings,
        },
        supports_check_mode=True,
    )
    given, check = module.params, module.check_mode
    try:
        changed = as_owner(given["folder"], given["owner"], lambda home: apply(home, given, check))
    except NotOwnedError as error:
        if not check:
            module.fail_json(msg=str(error))
        # On a bare machine, and on one whose folders would be mended first.
        changed = given["folders"] + [entry["path"] for entry in given["files"]]
    except OwnedError as error:
        module.fail_json(msg=str(error))
    module.exit_json(changed=bool(changed), paths=changed)


if __name__ == "__main__":
    main()
