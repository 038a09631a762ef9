#!/usr/bin/python
"""A file below a folder of a user, read as that user, for the controller."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_fetch
short_description: Fetches a file below a folder of a user, read as that user
description:
  - As M(ansible.builtin.fetch), but a process that became the owner of O(folder) reads the file,
    and follows no link below the folder. So a user cannot have a file of root fetched.
  - O(dest) is written by the part of this module that runs on the controller.
options:
  folder:
    description: The user's folder.
    type: path
    required: true
  path:
    description: Path of the file from there.
    type: str
    required: true
  dest:
    description: The file on the controller; without it only RV(checksum) is told.
    type: path
  limit_mb:
    description: A larger file is refused.
    type: int
    default: 32
author: The qRobot authors
attributes:
  check_mode:
    support: full
"""

EXAMPLES = r"""
- name: Fetch the report
  qrobot_fetch:
    folder: /var/lib/qrobot-health
    path: report.json
    dest: build/fleet/{{ inventory_hostname }}.json
"""

RETURN = r"""
checksum:
  description: SHA-1 of the file, as M(ansible.builtin.fetch) and M(ansible.builtin.stat) tell it.
  returned: when the file is there
  type: str
"""

import base64
import os
import zlib

from ansible.module_utils.basic import AnsibleModule
from ansible.module_utils.qrobot_owned import OwnedError, as_owner


def pack(home, name, limit_mb):
    """Content of a file, compressed and as text; None when it is not there."""
    handle = home.file(name)
    if handle is None:
        return None
    limit = limit_mb * 1_000_000
    with os.fdopen(handle, "rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise OwnedError(f"{home.path}/{name} has more than {limit_mb} MB: remove it and run again")
    return base64.b64encode(zlib.compress(content)).decode()


def main():
    """Run the robot's part."""
    module = AnsibleModule(
        argument_spec={
            "folder": {"type": "path", "required": True},
            "path": {"type": "str", "required": True},
            "dest": {"type": "path"},
            "limit_mb": {"type": "int", "default": 32},
        },
        supports_check_mode=True,
    )
    given = module.params
    try:
        found = as_owner(
            given["folder"], "", lambda home: pack(home, given["path"], given["limit_mb"])
        )
    except OwnedError as error:
        module.fail_json(msg=str(error))
    if found is None:
        module.fail_json(msg=f"{given['folder']}/{given['path']} is not there")
    module.exit_json(changed=False, packed=found)


if __name__ == "__main__":
    main()
