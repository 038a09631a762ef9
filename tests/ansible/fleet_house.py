"""What the tests of fleets share: our playbooks run on this machine, each host a folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from release_house import PLUGINS, load, program
from started import Program, run

ANSIBLE = PLUGINS.parent
release = load()
LOCAL = {"ansible_connection": "local", "ansible_python_interpreter": sys.executable}
# Nobody listens on port 1: the answer comes at once, without a network.
DEAD = {"ansible_connection": "ssh", "ansible_host": "127.0.0.1", "ansible_port": 1}
SETTINGS = {
    "ANSIBLE_CONFIG": str(Path(__file__).with_name("no_settings.cfg")),
    "ANSIBLE_GATHERING": "explicit",
    "ANSIBLE_LIBRARY": str(PLUGINS / "modules"),
    "ANSIBLE_MODULE_UTILS": str(PLUGINS / "module_utils"),
    "ANSIBLE_ACTION_PLUGINS": str(PLUGINS / "action"),
    "ANSIBLE_LOOKUP_PLUGINS": str(PLUGINS / "lookup"),
    "ANSIBLE_CALLBACK_PLUGINS": str(PLUGINS / "callback"),
    "ANSIBLE_CALLBACKS_ENABLED": "qrobot_outcome",
    "ANSIBLE_PIPELINING": "1",
    "ANSIBLE_SSH_RETRIES": "0",
    "ANSIBLE_NOCOLOR": "1",
    "LC_ALL": "C.UTF-8",
}
PLAYBOOK = Program(
    "ansible-playbook", "playbook_program:main",
    environment=SETTINGS | {"ANSIBLE_HOME": "{folder}/ansible", "ANSIBLE_LOCAL_TEMP": "{folder}"},
)  # fmt: skip


class Environment(release.Releases):
    """Releases whose environments are made of metadata: what is installed is read, not run."""

    packages: dict[str, str]

    def _build(self, target: Path, build: Path, requirements: str, *_: Any) -> None:
        for name, version in self.packages.items():
            info = target / f"lib/python3.11/site-packages/{name}-{version}.dist-info"
            info.mkdir(parents=True)
            head = f"Metadata-Version: 2.1\nClassifier: x\n  folded\nName: {name}\n"
            # What follows the head is a text that may hold the same words.
            (info / "METADATA").write_text(f"{head}Version: {version}\n\nVersion: 99\n")


def robot(root: Path, name: str, packages: dict[str, str]) -> Environment:
    """A root with one release in use."""
    made = Environment(root)
    made.packages = packages
    (root / "wheels").mkdir(parents=True, exist_ok=True)
    made.install(name, "", root / "wheels", "uv", "python", {"profile": "solver"})
    made.switch(name)
    return made


def stand_in(folder: Path, playbook: str, tasks: dict[str, list[dict[str, Any]]]) -> None:
    """Lay a playbook of ours into a folder, with other roles than its own.

    The playbook is byte for byte ours, and so is the role qrobot; every other role that it names
    has the tasks given, or none.
    """
    shutil.copy(ANSIBLE / playbook, folder)
    shutil.copytree(ANSIBLE / "roles/qrobot", folder / "roles/qrobot")
    names = {path.name for path in (ANSIBLE / "roles").iterdir()} - {"qrobot"}
    for name in names:
        made = folder / "roles" / name
        (made / "tasks").mkdir(parents=True)
        (made / "tasks/main.yml").write_text(json.dumps(tasks.get(name, [])))
        handlers = ANSIBLE / "roles" / name / "handlers"
        if handlers.is_dir():
            shutil.copytree(handlers, made / "handlers")


def play(
    folder: Path,
    playbook: Path,
    hosts: dict[str, dict[str, Any]],
    *options: str,
    environment: dict[str, str] | None = None,
    **more: Any,
) -> subprocess.CompletedProcess[str]:
    """Run a playbook on hosts, with extra variables; the answer with all that was printed."""
    inventory = {"all": {"hosts": hosts}}
    (folder / "inventory.json").write_text(json.dumps(inventory))
    # A short one: ansible-core 2.21 binds a socket in it, whose path may have 107 bytes.
    temporary = Path(tempfile.mkdtemp(prefix="q"))
    settings = (
        SETTINGS
        | {
            "ANSIBLE_REMOTE_TEMP": str(temporary),
            "ANSIBLE_ASYNC_DIR": str(temporary / "jobs"),  # "~" is the login's home, not HOME
            "PATH": os.environ["PATH"],
            "HOME": str(folder),
            "TMPDIR": str(temporary),
        }
        | (environment or {})
    )
    program("ansible-playbook")
    words = ["-i", folder / "inventory.json", playbook, *options, "--extra-vars", json.dumps(more)]
    try:
        return run(*words, folder=folder, environment=settings, program=PLAYBOOK, alone=True)
    finally:
        shutil.rmtree(temporary)
