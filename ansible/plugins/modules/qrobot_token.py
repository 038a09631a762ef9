#!/usr/bin/python
"""A random token in a file that only its owner reads, made once."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_token
short_description: A random token in a file that only its owner reads, made once
description:
  - The token is made on the robot and never returned, so no log of Ansible has it.
options:
  path:
    description:
      - The file. It is left, but for its mode, where it holds one line with a token of 32 or more
        letters, digits and C(._~+/=@:-), at least 8 of them different.
    type: path
    required: true
  variable:
    description: Name that the file gives to the token, as systemd's C(EnvironmentFile=) reads it.
    type: str
    required: true
author: The qRobot authors
"""

EXAMPLES = r"""
- name: Make a token for JupyterLab
  qrobot_token:
    path: /etc/qrobot/jupyter.token
    variable: JUPYTER_TOKEN
"""

RETURN = r"""#"""

import os
import re
import secrets
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule


STRONG = re.compile(r"[A-Za-z0-9._~+/=@:-]{32,}")


def holds_token(text, name):
    """Return whether the file is one line with a strong token.

    systemd takes quotes, comments and a second line that overrides the first: all of them may
    leave less of a token than there are characters.
    """
    given, line = text.removesuffix("\n").partition(name)[::2]
    return not given and bool(STRONG.fullmatch(line)) and len(set(line)) >= 8


def main():
    module = AnsibleModule(
        argument_spec={
            "path": {"type": "path", "required": True},
            "variable": {"type": "str", "required": True},
        },
        supports_check_mode=True,
    )
    name = module.params["variable"] + "="
    path = Path(module.params["path"])
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    present = holds_token(text, name)
    closed = present and path.stat().st_mode & 0o777 == 0o600
    if not module.check_mode:
        if not present:
            aside = path.with_name(path.name + ".new")
            aside.unlink(missing_ok=True)
            handle = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(handle, "w") as stream:
                stream.write(name + secrets.token_hex(24) + "\n")
                stream.flush()
                os.fsync(stream.fileno())
            aside.replace(path)
        elif not closed:
            path.chmod(0o600)
    module.exit_json(changed=not (present and closed))


if __name__ == "__main__":
    main()
