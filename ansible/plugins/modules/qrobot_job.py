#!/usr/bin/python
"""Whether a long task that the action qrobot_job started is still at work on this robot."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_job
short_description: Run a module that takes long, and notice when its robot is lost
description:
  - Starts a module on the robot, where it needs no connection, and asks for it now and then.
  - A robot that gives no answer for I(silence) seconds counts as unreachable. One that was
    restarted, or whose module was ended before its end, fails at the next question.
options:
  module:
    description: The module to run, such as C(ansible.builtin.apt).
    type: str
    required: true
  options:
    description: What the module is given.
    type: dict
    default: {}
  seconds:
    description: How long it may take; it is ended then. 0 runs it as any other module.
    type: int
    default: 7200
  poll:
    description: Seconds from one question to the next.
    type: float
    default: 10
  silence:
    description: Seconds without an answer after which the robot counts as lost.
    type: float
    default: 90
  state_of:
    description: The file of a job, of which the state is told; for the action alone.
    type: path
  jid:
    description: The job's number; for the action alone.
    type: str
author: The qRobot authors
"""

EXAMPLES = r"""
- name: Install packages
  qrobot_job:
    module: ansible.builtin.apt
    options:
      name: [chrony]
    seconds: 3600
"""

RETURN = r"""#"""

import json
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule


def finished(path):
    """Return whether the module has written its result; None: nothing is there."""
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except ValueError:  # cut short by a full or a failing card
        return False
    return "started" not in told or bool(told.get("finished"))


def alive(jid, proc):
    """Return whether a process of the job is there: it has the job's number as an argument."""
    for path in proc.glob("[0-9]*/cmdline"):
        try:
            if jid.encode() in path.read_bytes().split(b"\0"):
                return True
        except OSError:  # it ended meanwhile
            continue
    return False


def main():
    module = AnsibleModule(
        argument_spec={
            "state_of": {"type": "path", "required": True},
            "jid": {"type": "str", "required": True},
        },
        supports_check_mode=True,
    )
    path, proc = Path(module.params["state_of"]), Path("/proc")
    # In this sequence: a job that ends meanwhile has written its result before it was gone.
    working = alive(module.params["jid"], proc)
    done = finished(path)
    module.exit_json(
        changed=False,
        finished=bool(done),
        working=working,
        kept=done is not None,
        boot=(proc / "sys/kernel/random/boot_id").read_text(encoding="utf-8").strip(),
    )


if __name__ == "__main__":
    main()
