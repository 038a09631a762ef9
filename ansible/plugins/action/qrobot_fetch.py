"""Fetches a file below a folder of a user, read on the robot as that user."""

from __future__ import annotations

import base64
import hashlib
import os
import zlib
from pathlib import Path

from ansible.errors import AnsibleActionFail
from ansible.plugins.action import ActionBase


class ActionModule(ActionBase):
    """The part of qrobot_fetch that runs on the controller."""

    _supports_check_mode = True
    _supports_async = False

    def run(self, tmp=None, task_vars=None):
        """Ask for the content, and write it where it is not there yet."""
        result = super().run(tmp, task_vars)
        del tmp
        _, given = self.validate_argument_spec(
            argument_spec={
                "folder": {"type": "path", "required": True},
                "path": {"type": "str", "required": True},
                "dest": {"type": "path"},
                "limit_mb": {"type": "int", "default": 32},
            }
        )
        asked = {name: given[name] for name in ("folder", "path", "limit_mb")}
        answer = self._execute_module(
            module_name="qrobot_fetch", module_args=asked, task_vars=task_vars
        )
        text = answer.pop("packed", None)
        if text is None:
            return answer
        content = zlib.decompress(base64.b64decode(text))
        result["checksum"] = hashlib.sha1(content, usedforsecurity=False).hexdigest()
        result["changed"] = False
        if given["dest"] is None:
            return result
        dest = Path(given["dest"])
        try:
            result["changed"] = not dest.is_file() or dest.read_bytes() != content
            if result["changed"] and not self._task.check_mode:
                dest.parent.mkdir(parents=True, exist_ok=True)
                aside = dest.with_name(f".{dest.name}.{os.getpid()}")
                aside.write_bytes(content)
                aside.replace(dest)
        except OSError as error:
            raise AnsibleActionFail(f"{error.filename or dest}: {error.strerror}") from None
        return result
