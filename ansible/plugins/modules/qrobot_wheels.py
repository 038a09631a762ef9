#!/usr/bin/python
"""Which wheels a robot lacks; unpacks and verifies those that came."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_wheels
short_description: Sends the wheels that a robot lacks, verified on both sides
description:
  - The files are compared by size and SHA-256; only what lacks or differs is sent, in tar files of
    about O(chunk_mb).
  - A run that is interrupted between two chunks is completed by the next one, which sends only the
    rest.
  - O(state) and O(archive) are for the part of this module that runs on the controller.
options:
  src:
    description: Folder of the files on the controller. Needed in a task.
    type: path
  dest:
    description: Folder on the robot; it is made.
    type: path
    default: /opt/qrobot/wheels
  files:
    description: The files, each with C(name), C(size) in bytes and C(sha256).
    type: list
    elements: dict
    required: true
  chunk_mb:
    description: How much is sent at once.
    type: int
    default: 48
  state:
    description: Set by the controller's part.
    type: str
    choices: [missing, unpacked]
    default: missing
  archive:
    description: Set by the controller's part.
    type: path
author: The qRobot authors
attributes:
  check_mode:
    support: full
"""

EXAMPLES = r"""
- name: Send the wheels
  qrobot_wheels:
    src: build/wheelhouse/edge-aarch64-313
    files: "{{ wheelhouse.files }}"
"""

RETURN = r"""
msg:
  description: How many files and MB were sent.
  returned: always
  type: str
files:
  description: How many files were sent, or would be in check mode.
  returned: always
  type: int
mb:
  description: Their size.
  returned: always
  type: float
chunks:
  description: How many transfers it took.
  returned: always
  type: int
"""

import errno
import hashlib
import os
import re
import shutil
import tarfile
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._+!~%-]*")
BLOCK = 1 << 20


class WheelError(Exception):
    """A file cannot be taken; the text is one sentence."""


def check(files):
    """List of files as given, each entry verified."""
    good = []
    for at, entry in enumerate(files):
        name, size, digest = (entry.get(key) for key in ("name", "size", "sha256"))
        if not NAME.fullmatch(str(name)):
            raise WheelError(f"files[{at}].name is {name!r}: give a plain file name")
        if not str(size).isdigit():
            raise WheelError(f"files[{at}].size of {name} is {size!r}: give the bytes")
        if not re.fullmatch(r"[0-9a-f]{64}", str(digest)):
            raise WheelError(f"files[{at}].sha256 of {name} is {digest!r}: give 64 digits")
        good.append({"name": name, "size": int(size), "sha256": digest})
    return good


def is_there(dest, entry):
    """Whether the file is in the folder with that size and content."""
    path = dest / entry["name"]
    if path.is_symlink() or not path.is_file() or path.stat().st_size != entry["size"]:
        return False
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest() == entry["sha256"]


def store(dest, source, entry):
    """Write one file under another name, verify it, and rename it."""
    part = dest / f".{entry['name']}.part"
    digest, size = hashlib.sha256(), 0
    try:
        handle = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o644)
        with open(handle, "wb") as file:
            os.fchmod(handle, 0o644)
            while block := source.read(BLOCK):
                file.write(block)
                digest.update(block)
                size += len(block)
            file.flush()
            os.fsync(handle)
        if size != entry["size"] or digest.hexdigest() != entry["sha256"]:
            raise WheelError(f"{entry['name']} did not arrive as it was sent: run it again")
        os.replace(part, dest / entry["name"])
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def unpack(archive, dest, files):
    """Take exactly the files given from an archive."""
    wanted = {entry["name"]: entry for entry in files}
    with tarfile.open(archive, "r:") as tar:
        for member in tar:
            entry = wanted.pop(member.name, None)
            if entry is None or not member.isfile():
                raise WheelError(f"the archive holds {member.name!r}, which was not announced")
            store(dest, tar.extractfile(member), entry)
    if wanted:
        raise WheelError(f"{sorted(wanted)[0]} is not in the archive: run it again")
    handle = os.open(dest, os.O_RDONLY | os.O_DIRECTORY)
    os.fsync(handle)
    os.close(handle)


def free(dest):
    """Bytes free for a folder that need not be there yet."""
    while not dest.is_dir():
        dest = dest.parent
    return shutil.disk_usage(dest).free


def advice(error):
    """Return what helps against an error of the system."""
    return "make room" if error.errno == errno.ENOSPC else "check the folder and its owner"


def main():
    """Run the robot's part."""
    module = AnsibleModule(
        argument_spec={
            "src": {"type": "path"},
            "dest": {"type": "path", "default": "/opt/qrobot/wheels"},
            "files": {"type": "list", "elements": "dict", "required": True},
            "chunk_mb": {"type": "int", "default": 48},
            "state": {"choices": ["missing", "unpacked"], "default": "missing"},
            "archive": {"type": "path"},
        },
        required_if=[("state", "unpacked", ["archive"])],
        supports_check_mode=True,
    )
    given = module.params
    dest = Path(os.path.abspath(given["dest"]))
    try:
        files = check(given["files"])
        if given["state"] == "missing":
            missing = [entry for entry in files if not is_there(dest, entry)]
            module.exit_json(changed=False, missing=missing, free=free(dest))
        if not module.check_mode:
            os.umask(0o022)
            dest.mkdir(parents=True, exist_ok=True)
            unpack(given["archive"], dest, files)
        module.exit_json(changed=True)
    except WheelError as error:
        module.fail_json(msg=str(error))
    except tarfile.TarError as error:
        module.fail_json(msg=f"the archive did not arrive as it was sent ({error}): run it again")
    except OSError as error:
        module.fail_json(msg=f"cannot write to {dest}: {error.strerror or error}: {advice(error)}")


if __name__ == "__main__":
    main()
