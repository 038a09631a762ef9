"""Runs a module that takes long on a robot, and notices when the robot is lost."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import PurePosixPath

from ansible.errors import AnsibleActionFail, AnsibleConnectionFailure, AnsibleError
from ansible.plugins.action import ActionBase
from ansible.utils.display import Display

SIGN_OF_LIFE = 60  # seconds from one line of progress to the next
AGAIN = "run it again: it goes on with what is there"
display = Display()


class ActionModule(ActionBase):
    """The part of qrobot_job that runs on the controller; the module has the documentation.

    Ansible's own polling takes every unanswered question for a hiccup and asks on for as long as
    the task may take, a robot that restarted included.
    """

    _supports_check_mode = True
    _supports_async = False

    def run(self, tmp=None, task_vars=None):
        """Start the module, and follow it."""
        super().run(tmp, task_vars)
        _, given = self.validate_argument_spec(
            argument_spec={
                "module": {"type": "str", "required": True},
                "options": {"type": "dict", "default": {}},
                "seconds": {"type": "int", "default": 7200},
                "poll": {"type": "float", "default": 10},
                "silence": {"type": "float", "default": 90},
            }
        )
        for name in ("poll", "silence"):
            if not given[name] > 0:
                raise AnsibleActionFail(f"{name} is {given[name]}: give more than 0 seconds")
        self.host = (task_vars or {}).get("inventory_hostname", "the robot")
        self.name = self._task.get_name()
        asked = {"module_name": given["module"], "module_args": given["options"]}
        try:
            if self._task.check_mode or given["seconds"] <= 0:
                return self._execute_module(**asked, task_vars=task_vars)
            self._task.async_val = given["seconds"]  # the wrapper on the robot ends it then
            started = self._execute_module(**asked, task_vars=task_vars, wrap_async=True)
            self._task.async_val = 0
            if not started.get("ansible_job_id") or started.get("failed"):
                return started
            return self._follow(started, given, task_vars)
        finally:
            self._task.async_val = 0
            self._remove_tmp_path(self._connection._shell.tmpdir)

    def _follow(self, started, given, task_vars):
        """Ask until the job is done or lost, and return its result."""
        with suppress(AnsibleError, KeyError):  # other connections than SSH have no such option
            self._connection.set_option("reconnection_retries", 0)
        begin = answered = said = time.monotonic()
        boot, session = None, 0
        while True:
            try:
                state = self._state(started, task_vars)
            except AnsibleConnectionFailure as error:
                self._wait_for_answer(time.monotonic() - answered, given["silence"], error)
            else:
                answered = time.monotonic()
                boot, session = boot or state["boot"], state.get("session") or session
                if state["finished"]:
                    return self._result(started, session, given["seconds"], task_vars)
                self._refuse_lost(state, boot)
            now = time.monotonic()
            # The wrapper needs a moment to end what took too long, and to say so.
            if now - begin > given["seconds"] + max(30, 3 * given["poll"]):
                raise AnsibleActionFail(
                    f"'{self.name}' took longer than {given['seconds']} s and was given up: {AGAIN}"
                )
            if now - said >= SIGN_OF_LIFE:
                said = now
                display.display(f"{self.host}: '{self.name}' is at work, {now - begin:.0f} s")
            time.sleep(given["poll"])

    def _state(self, started, task_vars, end_session=0):
        """Ask the robot for the job, and end what is left of its session."""
        state = self._execute_module(
            module_name="qrobot_job",
            module_args={
                "state_of": started["results_file"],
                "jid": started["ansible_job_id"].split(".")[0],
                "end_session": end_session,
            },
            task_vars=task_vars,
        )
        if state.get("failed") or "boot" not in state:
            raise AnsibleActionFail(
                f"'{self.name}' cannot be followed "
                f"({state.get('msg') or state.get('module_stderr') or 'no answer'}): {AGAIN}"
            )
        return state

    def _wait_for_answer(self, silent, silence, error):
        """Bear an unanswered question; after too many the robot counts as unreachable."""
        if silent >= silence:
            raise AnsibleConnectionFailure(
                f"no answer for {silent:.0f} s during '{self.name}' "
                f"({' '.join(str(error).split())}): look at its power and its network, {AGAIN}"
            ) from None
        with suppress(AttributeError):
            self._connection.reset()

    def _refuse_lost(self, state, boot):
        """Fail when the job is not done and can never be."""
        if state["boot"] != boot:
            why = "the robot was restarted"
        elif not state["kept"]:
            why = "the robot has no trace of it, as after a restart"
        elif not state["working"]:
            why = "it was ended from outside, or the memory did not suffice"
        else:
            return
        raise AnsibleActionFail(f"'{self.name}' did not reach its end: {why}; {AGAIN}")

    def _result(self, started, session, seconds, task_vars):
        """Fetch the result of a job that is done, and remove its file."""
        asked = {
            "jid": started["ansible_job_id"],
            "_async_dir": str(PurePosixPath(started["results_file"]).parent),
        }

        def ask(mode):
            return self._execute_module(
                module_name="ansible.legacy.async_status",
                module_args={**asked, "mode": mode},
                task_vars=task_vars,
            )

        result = ask("status")
        with suppress(AnsibleConnectionFailure):  # a file that stays harms nobody
            ask("cleanup")
        for name in ("ansible_job_id", "started", "finished", "results_file"):
            result.pop(name, None)
        if "child_pid" in result:  # what the wrapper writes of a module that it ended
            with suppress(AnsibleConnectionFailure):
                self._state(started, task_vars, end_session=session)
            raise AnsibleActionFail(
                f"'{self.name}' took longer than {seconds} s and was ended: {AGAIN}"
            )
        return result
