"""Long tasks: their results, and that a lost robot or a lost job is noticed at once.

The clock of these tests is a number that `sleep` raises: none of them waits for a limit.
"""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from fleet_house import ANSIBLE, LOCAL, play
from processes import gone
from release_house import PLUGINS

yaml = pytest.importorskip("yaml")
LIMITS = ("poll", "silence", "seconds")


FOLLOWED = ["sh", "-c", "echo one; echo two; echo three >&2"]
# As by the kernel when the memory does not suffice: the wrapper and all below it are gone.
KILLED = """
import os, signal, re, time
number = os.getpid()
for _ in range(9):
    status = open(f'/proc/{number}/status').read()
    above = int(re.search(r'PPid:\\s+(\\d+)', status)[1])
    words = open(f'/proc/{above}/cmdline', 'rb').read() if above > 1 else b''
    if b'async_wrapper' not in words and b'AnsiballZ' not in words: break
    number = above
    os.kill(number, signal.SIGSTOP)
    victims = globals().setdefault('victims', []) ; victims.append(number)
for victim in victims: os.kill(victim, signal.SIGKILL)
"""
LONG = "import os, time; {} open({!r}, 'w').write(str(os.getpid())); time.sleep(600)"
AWAY = {"in_its_group": "", "out_of_its_group": "os.setpgid(0, 0);"}
REFUSED = [("poll", 0), ("poll", -1), ("silence", 0), ("silence", -5)]


@dataclass
class Run:
    """Long tasks that ran on this machine, each on a host of its own: what was registered."""

    folder: Path
    told: dict[str, dict[str, Any]]
    failed: set[str]


def follow(folder: Path, jobs: dict[str, dict[str, Any]]) -> Run:
    hosts = {name: {**LOCAL, "job": {"poll": 0.2} | job} for name, job in jobs.items()}
    given = {"module": "ansible.legacy.command", "options": {"argv": "{{ job.argv }}"}}
    given |= {name: f"{{{{ job.{name} | default(omit) }}}}" for name in LIMITS}
    tasks = [
        {"name": "Work", "qrobot_job": given, "register": "told", "ignore_errors": True},
        {"ansible.builtin.debug": {"msg": "TOLD {{ inventory_hostname }} {{ told | to_json }}"}},
        {"ansible.builtin.fail": {"msg": "it failed"}, "when": "told is failed"},
    ]
    (folder / "play.yml").write_text(json.dumps([{"hosts": "all", "tasks": tasks}]))
    done = play(folder, folder / "play.yml", hosts, "--forks", "3")
    assert done.returncode == 2, done.stdout + done.stderr
    found = re.findall(r'^    "msg": ("TOLD .*")$', done.stdout, re.MULTILINE)
    texts = [json.loads(text).split(" ", 2)[1:] for text in found]
    failed = set(re.findall(r"^  (\w+) failed: it failed", done.stdout, re.MULTILINE))
    return Run(folder, {name: json.loads(text) for name, text in texts}, failed)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    jobs: dict[str, dict[str, Any]] = {
        "followed": {"argv": FOLLOWED},
        "direct": {"argv": FOLLOWED, "seconds": 0},
        "failing": {"argv": ["sh", "-c", "echo oh no >&2; exit 3"]},
        "killed": {"argv": [sys.executable, "-c", KILLED]},
    }
    for at, (name, value) in enumerate(REFUSED):
        jobs[f"refused{at}"] = {"argv": ["true"], name: value}
    return follow(tmp_path_factory.mktemp("jobs"), jobs)


def test_a_long_task_gives_what_its_module_gives(run: Run) -> None:
    followed, direct = run.told["followed"], run.told["direct"]
    for name in ("rc", "stdout_lines", "stderr_lines", "changed", "failed"):
        assert followed[name] == direct[name]
    assert followed["stdout_lines"] == ["one", "two"]
    assert "ansible_job_id" not in followed


def test_a_long_task_that_fails_says_why(run: Run) -> None:
    told = run.told["failing"]
    assert (told["rc"], told["stderr"]) == (3, "oh no")


def test_the_robots_of_tasks_that_failed_have_failed_and_no_others(run: Run) -> None:
    assert run.told.keys() - run.failed == {"followed", "direct"}


def test_a_job_whose_processes_were_ended_is_noticed(run: Run) -> None:
    told = run.told["killed"]
    assert "'Work' did not reach its end: it was ended from outside" in told["msg"]
    assert "run it again" in told["msg"]


@pytest.mark.slow
def test_a_task_that_takes_too_long_is_ended_on_the_robot(tmp_path: Path) -> None:
    """Also where its processes are not in the group that Ansible's wrapper ends."""
    own = {name: tmp_path / f"{name}.pid" for name in AWAY}
    scripts = {name: LONG.format(first, str(own[name])) for name, first in AWAY.items()}
    jobs = {
        name: {"argv": [sys.executable, "-c", script], "seconds": 4, "poll": 1}
        for name, script in scripts.items()
    }
    for name, told in follow(tmp_path, jobs).told.items():
        assert "'Work' took longer than 4 s and was ended" in told["msg"], name
        # On a busy machine it was ended before its first line.
        if own[name].exists() and own[name].read_text():
            assert gone(int(own[name].read_text())), name


def test_a_limit_that_cannot_be_is_refused(run: Run) -> None:
    for at, (name, value) in enumerate(REFUSED):
        sentence = rf"{name} is {float(value)}: give more than 0 seconds"
        assert re.search(sentence, run.told[f"refused{at}"]["msg"])


# The action by itself, with robots that answer as told


@pytest.fixture(scope="module")
def plugin() -> ModuleType:
    pytest.importorskip("ansible")
    path = PLUGINS / "action/qrobot_job.py"
    spec = importlib.util.spec_from_file_location("qrobot_job_action", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


GONE = object()
WORKING = {"finished": False, "working": True, "kept": True, "boot": "one"}


class Robot:
    """A stand-in for a robot: it answers each question with the next of the answers given."""

    def __init__(self, plugin: ModuleType, monkeypatch: pytest.MonkeyPatch, poll: float) -> None:
        from ansible.errors import AnsibleConnectionFailure

        self.plugin, self.poll, self.unreachable = plugin, poll, AnsibleConnectionFailure
        self.now, self.asked = 0.0, 0
        self.costs = [0.0]  # seconds until ssh gives up, the last one again and again
        clock = SimpleNamespace(monotonic=lambda: self.now, sleep=self._sleep)
        monkeypatch.setattr(plugin, "time", clock)

    def _sleep(self, seconds: float) -> None:
        self.now += seconds

    def follow(self, answers: list[Any], silence: float = 90, seconds: int = 7200) -> Any:
        """Follow a job; the last answer is repeated for ever."""
        action = self.plugin.ActionModule.__new__(self.plugin.ActionModule)
        action.host, action.name = "picker-1", "Install the release"
        action._connection = SimpleNamespace(
            set_option=lambda *_: None, reset=lambda: None, _shell=SimpleNamespace(tmpdir=None)
        )

        def answer(module_name: str, **_: Any) -> Any:
            if module_name != "qrobot_job":
                return {"rc": 0, "changed": True}
            one = answers[min(self.asked, len(answers) - 1)]
            self.asked += 1
            if one is GONE:
                self.now += self.costs.pop(0) if len(self.costs) > 1 else self.costs[0]
                raise self.unreachable("Connection timed out")
            return {"failed": False, **one}

        action._execute_module = answer
        given = {"poll": self.poll, "silence": silence, "seconds": seconds}
        started = {"ansible_job_id": "j1.2", "results_file": "/root/.ansible_async/j1.2"}
        return action._follow(started, given, {})


@pytest.fixture
def lonely(plugin: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Robot:
    return Robot(plugin, monkeypatch, poll=10)


def test_a_job_that_ends_gives_its_result(lonely: Robot) -> None:
    assert lonely.follow([WORKING, WORKING, WORKING | {"finished": True}])["rc"] == 0
    assert lonely.asked == 3


@pytest.mark.parametrize("costs", [[0], [3], [20], [60, 0], [60, 3], [60, 20]])
def test_a_robot_without_power_counts_as_unreachable_within_two_minutes(
    lonely: Robot, costs: list[float]
) -> None:
    # 60: ssh notices that the connection is dead (ansible.cfg); 20: it cannot connect.
    lonely.costs = list(costs)
    with pytest.raises(lonely.unreachable) as told:
        lonely.follow([WORKING, GONE])
    assert lonely.now <= 120
    sentence = str(told.value)
    assert "during 'Install the release' (Connection timed out)" in sentence
    assert re.match(r"no answer for \d+ s", sentence)
    assert "look at its power and its network" in sentence


def test_a_short_silence_is_borne(lonely: Robot) -> None:
    answers = [WORKING, GONE, GONE, GONE, WORKING, GONE, GONE, GONE, WORKING | {"finished": True}]
    assert lonely.follow(answers)["rc"] == 0


@pytest.mark.parametrize(
    ("state", "says"),
    [
        (WORKING | {"boot": "two"}, "the robot was restarted"),
        (WORKING | {"boot": "two", "working": False}, "the robot was restarted"),
        (WORKING | {"working": False, "kept": False}, "no trace of it, as after a restart"),
        (WORKING | {"working": False}, "it was ended from outside"),
    ],
)
@pytest.mark.parametrize("before", [[WORKING], [WORKING, GONE, GONE], [WORKING, WORKING]])
def test_a_job_that_can_never_end_fails_at_the_next_answer(
    lonely: Robot, before: list[Any], state: dict[str, Any], says: str
) -> None:
    from ansible.errors import AnsibleActionFail

    with pytest.raises(AnsibleActionFail, match=says):
        lonely.follow([*before, state])
    assert lonely.asked == len(before) + 1


def test_a_job_that_never_says_that_it_ended_is_given_up(lonely: Robot) -> None:
    from ansible.errors import AnsibleActionFail

    with pytest.raises(AnsibleActionFail, match="took longer than 300 s and was given up"):
        lonely.follow([WORKING], seconds=300)
    assert lonely.now <= 300 + 60


def test_the_limits_of_ssh_end_a_dead_connection_within_two_minutes() -> None:
    text = (ANSIBLE / "ansible.cfg").read_text()

    def number(pattern: str) -> int:
        found = re.search(pattern, text)
        assert found, pattern
        return int(found[1])

    dead = number(r"ServerAliveInterval=(\d+)") * number(r"ServerAliveCountMax=(\d+)")
    connect = number(r"(?m)^timeout = (\d+)$")
    retries = number(r"(?m)^retries = (\d+)$")
    # Ansible waits 2^n - 1 s before its n-th attempt more.
    assert dead + sum(connect + 2**n - 1 for n in range(1, retries + 1)) < 120
    # A long task: the connection dies after a question was due, then one more that connects.
    silence = yaml.safe_load((ANSIBLE / "roles/qrobot/defaults/main.yml").read_text())
    assert max(dead + 10, silence["qrobot_silence"]) + 10 + connect <= 120


def walk(node: Any) -> list[dict[str, Any]]:
    """Every mapping of a file, however deep."""
    if isinstance(node, dict):
        return [node, *(one for value in node.values() for one in walk(value))]
    return [one for value in node for one in walk(value)] if isinstance(node, list) else []


def test_no_task_polls_in_the_way_that_does_not_notice() -> None:
    jobs = []
    for path in [*ANSIBLE.glob("*.yml"), *ANSIBLE.glob("roles/*/*/*.yml")]:
        for node in walk(yaml.safe_load(path.read_text())):
            assert "async" not in node, f"{path.name}: use qrobot_job, which notices a lost robot"
            jobs += [node["qrobot_job"]] if "qrobot_job" in node else []
    assert len(jobs) >= 4
    assert all(job["silence"] == "{{ qrobot_silence }}" for job in jobs)
