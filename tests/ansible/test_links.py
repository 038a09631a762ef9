"""Root follows no link below a folder that a user owns: the roles' sources, and what they do.

The sources are searched, so that a new task which touches such a path fails here until it goes
through qrobot_files or qrobot_fetch. Then every path that those tasks name gets links planted in
each of its components, to a file and to a folder of somebody else, and the tasks of the roles run.
"""

from __future__ import annotations

import json
import os
import pwd
import re
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import qrobot_owned as owned
from fleet_house import ANSIBLE, LOCAL, play

yaml = pytest.importorskip("yaml")

OWNED = ("qrobot_home", "qrobot_reports", "/var/lib/qrobot-desktop")
OWNER = {"qrobot", "qrobot-desktop"}
SAFE = ("qrobot_files", "qrobot_fetch")
TOLD = ("assert", "debug", "fail", "set_fact")  # on the controller; no file is touched
TOKEN = "|".join(map(re.escape, OWNED))
# Something is put behind the folder: a path below it.
BELOW = re.compile(rf"(?:{TOKEN})(?![\w-])['\"]?\s*(?:\}}\}})?\s*(?:/|~|\|)")
NAMED = re.compile(rf"(?:{TOKEN})(?![\w-])")
RESERVED = {
    "name", "when", "register", "tags", "loop", "loop_control", "vars", "notify", "no_log", "diff",
    "changed_when", "failed_when", "check_mode", "async", "poll", "environment", "become",
    "delegate_to", "run_once", "ignore_unreachable", "ignore_errors", "listen", "become_user",
    "until", "retries", "delay", "any_errors_fatal",
}  # fmt: skip
SECRETS = {
    "credentials_aws_access_key_id": "AKIAPLANTED",
    "credentials_aws_secret_access_key": "planted-aws-secret",
    "credentials_ibm_token": "planted-ibm-token",
    "credentials_dwave_token": "planted-dwave-token",
}


def each_task(steps: Any) -> Iterator[dict[str, Any]]:
    """Every task of a list, those in blocks too."""
    for step in steps or []:
        blocks = [step[key] for key in ("block", "rescue", "always") if key in step]
        if not blocks:
            yield step
        for block in blocks:
            yield from each_task(block)


def tasks() -> Iterator[tuple[str, dict[str, Any]]]:
    """Every task and handler of the roles and playbooks, with its file."""
    for path in sorted(ANSIBLE.glob("roles/*/*/*.yml")):
        if path.parent.name in ("tasks", "handlers"):
            for task in each_task(yaml.safe_load(path.read_text())):
                yield str(path.relative_to(ANSIBLE)), task
    for path in sorted(ANSIBLE.glob("*.yml")):
        for one in yaml.safe_load(path.read_text()):
            for key in ("pre_tasks", "tasks", "post_tasks", "handlers"):
                for task in each_task(one.get(key)):
                    yield path.name, task


def module_of(task: dict[str, Any]) -> tuple[str, Any]:
    """Module of a task, and its arguments."""
    names = [key for key in task if key not in RESERVED]
    assert len(names) == 1, f"{task.get('name')}: which of {names} is the module?"
    return names[0].removeprefix("ansible.builtin."), task[names[0]]


def leaves(value: Any, at: str = "") -> Iterator[tuple[str, str]]:
    """Every text in the arguments of a task, with the name of its argument."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, str(key))
    elif isinstance(value, list):
        for inner in value:
            yield from leaves(inner, at)
    else:
        yield at, str(value)


def unwrapped(task: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """The task that a job is, with an argv that stands in its variables in its place."""
    variables, options = dict(task.get("vars", {})), dict(given["options"])
    name = str(options.get("argv")).strip("{} ")
    if isinstance(variables.get(name), list):
        options["argv"] = variables.pop(name)
    kept = {key: value for key, value in task.items() if key in RESERVED}
    return kept | {"vars": variables, given["module"].removeprefix("ansible.legacy."): options}


def fault_of(task: dict[str, Any]) -> str:
    """Say how root may follow a link of a user in this task; "" when it cannot."""
    module, given = module_of(task)
    if module == "qrobot_job":  # runs another module
        return fault_of(unwrapped(task, given))
    if module in SAFE or module in TOLD:
        return ""
    argv = given.get("argv", []) if isinstance(given, dict) else []
    if module == "command" and argv[:2] == ["runuser", "--user=qrobot"]:
        given = {"chdir": given.get("chdir", "")}
    if module == "stat" and all(
        given.get(key) is False for key in ("follow", "get_checksum", "get_mime", "get_attributes")
    ):
        return ""  # lstat
    found = list(leaves(given)) + [
        pair for key in ("loop", "vars", "environment") for pair in leaves(task.get(key), key)
    ]
    for at, text in found:
        if BELOW.search(text):
            return f"{module}: {at}: {text} is below a folder of a user: use qrobot_files"
        # The folder itself lies in a folder of root.
        if NAMED.search(text) and module not in ("file", "user") and at != "chdir":
            return f"{module}: {at}: {text} is a folder of a user"
    deep = isinstance(given, dict) and given.get("recurse")
    if deep and any(NAMED.search(text) for _, text in found):
        return f"{module}: recurse goes below a folder of a user"
    return ""


def test_no_task_of_root_touches_a_path_below_a_users_folder() -> None:
    found = [f"{place}: {task.get('name')}: {fault}" for place, task in tasks()
             if (fault := fault_of(task))]  # fmt: skip
    assert found == []
    assert {module_of(task)[0] for _, task in tasks()} >= {*SAFE, "file", "command", "stat"}


@pytest.mark.parametrize(
    "task",
    [
        # How the roles did it before.
        {"ansible.builtin.file": {"path": "{{ qrobot_home }}/work", "state": "directory"}},
        {"ansible.builtin.file": {"path": "{{ qrobot_home }}/{{ item }}"}, "loop": [".aws"]},
        {"ansible.builtin.template": {"dest": "{{ qrobot_home }}/{{ item.folder }}/f"}},
        {
            "ansible.builtin.find": {
                "paths": "{{ x | map('regex_replace', '^', qrobot_home ~ '/') }}"
            }
        },
        {"ansible.builtin.fetch": {"src": "{{ qrobot_reports }}/report.json", "dest": "here"}},
        {"ansible.builtin.stat": {"path": "{{ qrobot_reports }}/report.json"}},
        # What somebody could add.
        {"ansible.builtin.copy": {"content": "", "dest": "{{ qrobot_home }}"}},
        {"ansible.builtin.file": {"path": "{{ item }}"}, "loop": ["{{ qrobot_home }}/a"]},
        {"ansible.builtin.file": {"path": "{{ qrobot_home }}", "recurse": True}},
        {"ansible.builtin.command": {"argv": ["rm", "-rf", "{{ qrobot_reports }}"]}},
        {"ansible.builtin.copy": {"dest": "/var/lib/qrobot-desktop/.config"}},
        {
            "qrobot_job": {"module": "ansible.legacy.command", "options": {"argv": "{{ x }}"}},
            "vars": {"x": ["rm", "-rf", "{{ qrobot_home }}/y"]},
        },
        {"ansible.builtin.slurp": {"src": "{{ [qrobot_home, '.x'] | join('/') }}"}},
    ],
)
def test_a_task_that_root_could_be_led_by_is_found(task: dict[str, Any]) -> None:
    assert fault_of(task)


def test_the_folders_of_users_are_known_to_this_test() -> None:
    """A role that gives another folder to a user must be added to OWNED."""
    for place, task in tasks():
        module, given = module_of(task)
        texts = dict(leaves([given, task.get("loop")]))
        if module == "user" and given.get("state") != "absent":
            assert NAMED.search(given["home"]), place
            assert given["name"] in OWNER
        for item in task.get("loop") if isinstance(task.get("loop"), list) else [given]:
            owner = item.get("owner") if isinstance(item, dict) else None
            if owner and module not in SAFE and owner not in ("root", "{{ item.owner }}"):
                assert NAMED.fullmatch(item["path"].strip("{} ")), (place, texts)
    for unit in ANSIBLE.glob("roles/*/templates/*.service.j2"):
        text = unit.read_text()
        for folder in re.findall(r"^StateDirectory=(.*)$", text, re.MULTILINE):
            assert f"/var/lib/{folder}" in OWNED
        # What root's systemd starts is not root, and writes as that user.
        assert re.search(r"^User=(.*)$", text, re.MULTILINE)[1] in OWNER  # type: ignore[index]


# What the tasks do


def planted_tasks(module: str) -> list[dict[str, Any]]:
    """Tasks of the roles that use a module, for a user of this computer, and without conditions."""
    found = []
    for place, task in tasks():
        if module_of(task)[0] != module or not place.startswith("roles/"):
            continue
        kept = {key: task[key] for key in ("name", "vars", "no_log", module) if key in task}
        kept[module] = {**task[module]}
        if module == "qrobot_files":
            kept[module]["owner"] = "{{ someone }}"
        found.append({**kept, "register": "done", "ignore_errors": True})
    assert found
    return found


def someone() -> pwd.struct_passwd:
    """Who owns the homes: not root, where root runs this."""
    return pwd.getpwnam("nobody") if os.geteuid() == 0 else pwd.getpwuid(os.geteuid())


def own(path: Path) -> None:
    """Give a folder and what is in it to that user."""
    for one in [path, *path.rglob("*")]:
        if os.geteuid() == 0:
            os.chown(one, someone().pw_uid, someone().pw_gid, follow_symlinks=False)


def tree(folder: Path) -> dict[str, tuple[Any, ...]]:
    """All that is in a folder: kinds, modes, owners, contents, targets."""
    found = {}
    for path in [folder, *sorted(folder.rglob("*"))]:
        seen = path.lstat()
        content = path.read_bytes() if stat.S_ISREG(seen.st_mode) else b""
        target = os.readlink(path) if path.is_symlink() else ""
        found[str(path.relative_to(folder))] = (
            seen.st_mode, seen.st_uid, seen.st_gid, content, target)  # fmt: skip
    return found


def run(
    folder: Path,
    steps: list[dict[str, Any]],
    hosts: dict[str, dict[str, Any]],
    meant: dict[str, list[int]] | None = None,
) -> str:
    """Run tasks on hosts (of each those `meant`); what was said, secrets must not be in it."""
    defaults: dict[str, Any] = {}
    for role in ("qrobot", "credentials", "jupyter", "release"):
        defaults |= yaml.safe_load((ANSIBLE / f"roles/{role}/defaults/main.yml").read_text())
    for name in ("qrobot_home", "qrobot_reports", "qrobot_fetched"):
        defaults.pop(name)
    for name in SECRETS:
        defaults.pop(name)
    (folder / "templates").mkdir(exist_ok=True)  # those of all roles, beside the play
    for path in ANSIBLE.glob("roles/*/templates/*"):
        shutil.copy(path, folder / "templates")
    clear = {"hosts": "all", "gather_facts": False, "vars": defaults | SECRETS, "tasks": steps}
    plays = [clear]
    if meant is not None:  # a task that is skipped costs as much as one that runs
        plays = [
            {**clear, "hosts": [name for name in hosts if at in meant[name]], "tasks": [step]}
            for at, step in enumerate(steps)
        ]
    (folder / "play.yml").write_text(json.dumps(plays))
    done = play(folder, folder / "play.yml", hosts, someone=someone().pw_name)
    assert done.returncode == 0, done.stdout + done.stderr
    for secret in SECRETS.values():
        assert secret not in done.stdout + done.stderr
    return " ".join(done.stdout.split())


@pytest.fixture
def opened(tmp_path: Path) -> Path:
    """A folder that the other user may enter: pytest closes its own."""
    for path in [tmp_path, *list(tmp_path.parents)[:3]]:
        if os.geteuid() == 0 and path != Path("/tmp"):
            path.chmod(path.stat().st_mode | 0o711)
    return tmp_path


def components(paths: list[str]) -> list[str]:
    """Each path and each folder on its way."""
    return sorted({"/".join(path.split("/")[: end + 1]) for path in paths
                   for end in range(path.count("/") + 1)})  # fmt: skip


@pytest.mark.slow
def test_links_below_the_home_are_not_followed(opened: Path) -> None:
    keep = {
        "ansible.builtin.copy": {"content": "{{ done | to_json }}", "dest": "{{ told }}.{{ item }}"}
    }
    steps = planted_tasks("qrobot_files")
    clean = opened / "clean"
    clean.mkdir()
    own(clean)
    shown = [part for at, task in enumerate(steps)
             for part in (task, {**keep, "loop": [at], "no_log": True})]  # fmt: skip
    run(
        opened, shown, {"clean": {**LOCAL, "qrobot_home": str(clean), "told": str(opened / "told")}}
    )
    told = [json.loads((opened / f"told.{at}").read_text()) for at in range(len(steps))]
    assert not any(one.get("failed") for one in told), told
    paths = [path for one in told for path in one["paths"]]
    assert {
        ".aws/credentials",
        ".config/dwave/dwave.conf",
        ".qiskit/qiskit-ibm.json",
        "work",
    } <= set(paths)
    for path in clean.rglob("*"):
        assert stat.S_IMODE(path.stat().st_mode) == (0o700 if path.is_dir() else 0o600)
        assert path.stat().st_uid == someone().pw_uid
    assert "planted-dwave-token" in (clean / ".config/dwave/dwave.conf").read_text()

    # A home is given to those tasks that made something in the folder with its link.
    hosts, before, places, meant = {}, {}, {}, {}
    for number, place in enumerate(components(paths)):
        top = place.split("/")[0]
        touching = [at for at, one in enumerate(told) if top in components(one["paths"])]
        for kind in ("file", "folder"):
            name = f"{kind}{number}"
            home, victim = opened / name, opened / f"{name}-victim"
            victim.mkdir(mode=0o755)
            (victim / "inner").mkdir(mode=0o755)
            (victim / "private").write_text("kept")
            # What a task would look for behind the link.
            for leaf in {path.rsplit("/", 1)[-1] for path in paths}:
                (victim / leaf).write_text("kept")
                (victim / leaf).chmod(0o644)
            link = home / place
            link.parent.mkdir(parents=True)
            link.symlink_to(victim / "private" if kind == "file" else victim)
            own(home)
            hosts[name], meant[name] = {**LOCAL, "qrobot_home": str(home)}, touching
            before[name], places[name] = tree(victim), place
    said = run(opened, steps, hosts, meant)
    for name, place in places.items():
        assert tree(opened / f"{name}-victim") == before[name], place
        assert (opened / name / place).is_symlink(), place
        assert f"{opened}/{name}/{place} is a link, and qRobot follows none below" in said


def test_links_below_the_reports_are_not_followed(opened: Path) -> None:
    hosts = {}
    (opened / "victim").mkdir()
    (opened / "victim/private").write_text("kept-by-root")
    steps = planted_tasks("qrobot_fetch")
    release = {"id": "1-solver-a", "current": None}
    for name in ("link", "plain", "pipe", "folder", "large"):
        reports = opened / name
        reports.mkdir()
        report = reports / "1-solver-a.json"
        if name == "link":
            report.symlink_to(opened / "victim/private")
        elif name == "pipe":
            os.mkfifo(report)
        elif name == "folder":
            report.mkdir()
        elif name == "large":
            with report.open("wb") as file:
                file.truncate(10**9)
        else:
            report.write_text("plain")
        own(reports)
        hosts[name] = {**LOCAL, "qrobot_reports": str(reports), "release_installed": release}
    fetched = opened / "fetched"
    for host in hosts.values():
        host["qrobot_fetched"] = str(fetched)
    said = run(opened, steps, hosts)
    assert {path.name: path.read_text() for path in fetched.iterdir()} == {
        "plain.json": "plain",
        "plain.failed.json": "plain",
    }
    assert f"{opened}/link/1-solver-a.json is a link, and qRobot follows none below" in said
    assert f"{opened}/pipe/1-solver-a.json is not a plain file" in said
    assert f"{opened}/large/1-solver-a.json has more than 32 MB" in said


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
def test_the_work_is_done_by_the_owner_for_good(opened: Path) -> None:
    """Whatever is put there meanwhile: the process may no more than its owner."""
    home, victim = opened / "home", opened / "victim"
    home.mkdir()
    victim.mkdir()
    own(home)

    def work(folder: Any) -> list[Any]:
        seen = [os.getresuid(), os.getresgid(), os.getgroups()]
        for escape in (lambda: os.setuid(0), lambda: (victim / "new").write_text("x")):
            with pytest.raises(PermissionError):
                escape()
        return seen

    uid, gid = someone().pw_uid, someone().pw_gid
    assert owned.as_owner(str(home), "nobody", work) == [[uid] * 3, [gid] * 3, []]
    assert os.getresuid() == (0, 0, 0)
    assert list(victim.iterdir()) == []
    with pytest.raises(owned.NotOwnedError, match="belongs to root and not to nobody"):
        owned.as_owner(str(victim), "nobody", work)


@pytest.mark.parametrize("name", ["/etc/passwd", "../x", "a/../../x", ""])
def test_a_path_that_leaves_the_folder_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(owned.OwnedError, match="give a path below"):
        owned.as_owner(str(tmp_path), "", lambda folder: folder.file(name))


def test_a_child_that_fails_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(owned.OwnedError, match="ended without an answer"):
        owned.as_owner(str(tmp_path), "", lambda folder: 1 // 0)
