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
  end_session:
    description: The session of which all processes are ended; for the action alone.
    type: int
    default: 0
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
import os
import signal
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


def session_of(pid, proc):
    """Return the session of a process."""
    # Behind the name, which may hold anything: state, parent, group, session.
    return int((proc / pid / "stat").read_text(errors="replace").rpartition(")")[2].split()[3])


def session_of_job(jid, proc):
    """Return the session of a job, 0 when it has ended: it has its number as an argument."""
    for path in proc.glob("[0-9]*/cmdline"):
        try:
            if jid.encode() in path.read_bytes().split(b"\0"):
                return session_of(path.parent.name, proc)
        except OSError:  # it ended meanwhile
            continue
    return 0


def end(session, proc):
    """End what is left of a job that took too long.

    Ansible's wrapper ends the process group of the module, which a process that was started
    before the group was made is not in.
    """
    for path in proc.glob("[0-9]*"):
        try:
            if session_of(path.name, proc) == session:
                os.kill(int(path.name), signal.SIGKILL)
        except OSError:  # it ended meanwhile
            continue


def main():
    module = AnsibleModule(
        argument_spec={
            "state_of": {"type": "path", "required": True},
            "jid": {"type": "str", "required": True},
            "end_session": {"type": "int", "default": 0},
        },
        supports_check_mode=True,
    )
    path, proc = Path(module.params["state_of"]), Path("/proc")
    # In this sequence: a job that ends meanwhile has written its result before it was gone.
    session = session_of_job(module.params["jid"], proc)
    done = finished(path)
    left = module.params["end_session"]
    # Never the session of the connection: a job that could not leave it would end us, too.
    if left and left != os.getsid(0) and not module.check_mode:
        end(left, proc)
    module.exit_json(
        changed=False,
        finished=bool(done),
        working=bool(session),
        session=session,
        kept=done is not None,
        boot=(proc / "sys/kernel/random/boot_id").read_text(encoding="utf-8").strip(),
    )


if __name__ == "__main__":
    main()
