"""What became of every robot: told at the end, with the reason of each that is not done."""

from __future__ import annotations

DOCUMENTATION = r"""
name: qrobot_outcome
type: aggregate
short_description: What became of every robot
description:
  - Ends a run that has no robot at all with exit code 1, before it asks for anything.
  - Names at the end the robots that failed, did not answer, were stopped or were not begun.
"""

from ansible.plugins.callback import CallbackBase

NO_ROBOT = (
    "no robot is chosen: the inventory names none, or LIMIT leaves none; name your robots in "
    "ansible/inventory/hosts.yml (docs/provisioning.md). Nothing was done"
)
VALIDATION = ("validate_argument_spec", "ansible.builtin.validate_argument_spec")
ARGUMENTS = "Validation of arguments failed: "
LENGTH = 600  # of a reason, in characters; the whole stands above


def sentence(result):
    """Return what a task said about its failure, in one line."""
    told = result.get("msg")
    parts = [part for part in result.get("results") or [] if isinstance(part, dict)]
    bad = [part for part in parts if part.get("failed") or part.get("unreachable")]
    if bad:
        told = bad[0].get("msg") or told
    if result.get("censored") or (bad and bad[0].get("censored")):
        told = "its answer is hidden, because it may hold a secret"
    if "non-zero return code" in str(told):
        lines = f"{result.get('stderr') or ''}\n{result.get('stdout') or ''}".split("\n")
        said = [line for line in lines if line.strip()]
        told = f"exit code {result.get('rc')}" + (f": {said[-1]}" if said else "")
    told = "no reason was given" if told in (None, "") else told
    text = " ".join(str(told).split()).removeprefix("Task failed: ")
    return text if len(text) <= LENGTH else f"{text[: LENGTH - 4]} ..."


class CallbackModule(CallbackBase):
    """Follows each robot through all batches."""

    CALLBACK_VERSION = 2.0
    CALLBACK_TYPE = "aggregate"
    CALLBACK_NAME = "qrobot_outcome"
    CALLBACK_NEEDS_ENABLED = True

    def __init__(self):
        super().__init__()
        self.asked = []
        self.batch = []
        self.reasons = {}
        self.stopped = []
        self.common = []

    def v2_playbook_on_start(self, playbook):
        for play in playbook.get_plays():
            self.asked += [name for name in hosts(play) if name not in self.asked]
        if not self.asked:
            self._display.error(NO_ROBOT, wrap_text=False)
            raise SystemExit(1)

    def v2_playbook_on_play_start(self, play):
        self.batch = hosts(play)

    def v2_playbook_on_no_hosts_remaining(self):
        self.stopped += self.batch

    def v2_runner_on_failed(self, result, ignore_errors=False):
        if ignore_errors:
            return
        reason = sentence(result.result)
        if result.task.run_once:  # it speaks for all robots, not for the one that it ran on
            self.common.append(reason)
        else:
            name, task = result.host.get_name(), result.task
            reason = reason.removeprefix(f"{name}: ").removeprefix(ARGUMENTS)
            where = "" if task.action in VALIDATION else f" (task '{task.get_name()}')"
            self.reasons[name] = f"failed: {reason}{where}"

    def v2_runner_on_unreachable(self, result):
        self.reasons[result.host.get_name()] = f"did not answer: {sentence(result.result)}"

    def v2_playbook_on_stats(self, stats):
        lines = [f"  {reason}" for reason in self.common]
        lost = 0
        for name in self.asked:
            why = self._why(name, stats)
            lost += bool(why)
            lines += [f"  {name} {why}"] if why else []
        total = len(self.asked)
        done = f"{total - lost} of {total} robots" if lost else f"{total} robot{'s' * (total > 1)}"
        ended = "the run reached its end on"
        if lines:
            self._display.display("\n".join([f"Not as it should be; {ended} {done}:", *lines]))
        else:
            self._display.display(f"No robot failed: {ended} {done}.")

    def _why(self, name, stats):
        """Return why a robot is not done, "" when it is."""
        if name in stats.dark or name in stats.failures:
            # Where a task of all robots failed, Ansible counts it with the first of them.
            return self.reasons.get(name, "")
        if name not in stats.processed:
            return "was not begun: a batch before its own failed"
        if name in self.stopped:
            return "was stopped: another robot of its batch failed"
        return ""


def hosts(play):
    """Return the names of a play's robots: of its batch, once it runs."""
    inventory = play.get_variable_manager()._inventory
    return [host.get_name() for host in inventory.get_hosts(play.hosts)]
