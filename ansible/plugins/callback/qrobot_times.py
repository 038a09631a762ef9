"""How long each role took, on every host: printed at the end, and kept as JSON on request."""

from __future__ import annotations

DOCUMENTATION = r"""
name: qrobot_times
type: aggregate
short_description: How long each role took
description:
  - Prints each role's share of the run, and writes it to the file that QROBOT_TIMES names.
"""

import json
import os
import time
from pathlib import Path

from ansible.plugins.callback import CallbackBase


class CallbackModule(CallbackBase):
    """Times are of the controller's clock: a task with several hosts counts once."""

    CALLBACK_VERSION = 2.0
    CALLBACK_TYPE = "aggregate"
    CALLBACK_NAME = "qrobot_times"
    CALLBACK_NEEDS_ENABLED = True

    def __init__(self):
        super().__init__()
        self.begin = time.monotonic()
        self.since = self.begin
        self.role = None
        self.roles = {}
        self.tasks = []
        self.task = None

    def _close(self):
        now = time.monotonic()
        if self.task is not None:
            self.roles[self.role] = self.roles.get(self.role, 0.0) + now - self.since
            self.tasks.append((self.role, self.task, now - self.since))
        self.since = now

    def _open(self, task):
        self._close()
        self.role = task._role.get_name() if task._role else "play"
        self.task = task.get_name()

    def v2_playbook_on_task_start(self, task, is_conditional):
        self._open(task)

    def v2_playbook_on_handler_task_start(self, task):
        self._open(task)

    def v2_playbook_on_stats(self, stats):
        self._close()
        total = time.monotonic() - self.begin
        roles = {name: round(spent, 1) for name, spent in self.roles.items()}
        parts = sorted(roles.items(), key=lambda part: -part[1])
        shares = ", ".join(f"{name} {spent:.0f} s" for name, spent in parts if spent >= 1)
        self._display.display(f"Time: {total:.0f} s" + (f" ({shares})" if shares else ""))
        target = os.environ.get("QROBOT_TIMES")
        if target:
            slowest = sorted(self.tasks, key=lambda task: -task[2])[:15]
            data = {
                "seconds": round(total, 1),
                "roles": roles,
                "slowest": [
                    {"role": role, "task": task, "seconds": round(spent, 1)}
                    for role, task, spent in slowest
                ],
                "hosts": {host: stats.summarize(host) for host in sorted(stats.processed)},
            }
            Path(target).write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
