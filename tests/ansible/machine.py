"""A Debian machine with systemd and sshd on this computer, in a second: no image, no emulator.

Its processes, mounts, network, host name and control group are its own; the kernel is the
computer's. What is written lies in memory and goes with the machine. It reaches nothing but a
proxy for apt here. Needs root on Linux; `why_not` tells what is missing.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from machine_proxy import serve
from processes import HANG, until

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PLAYBOOKS = ROOT / "ansible"
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "qrobot" / "test-machine"
RELEASE = os.environ.get("QROBOT_ROLES_RELEASE", "trixie")
TOOLS = ("mmdebstrap", "unshare", "setpriv", "nsenter", "ip", "ssh", "ssh-keygen")
NAME = "robot"


def why_not() -> str:
    """Say why no machine can be tried here, "" when one can."""
    if not os.environ.get("QROBOT_ROLES"):
        return "starts a machine and provisions it, minutes: QROBOT_ROLES=1 (as root, on Debian)"
    if os.geteuid() or sys.platform != "linux":
        return "a machine in namespaces wants root on Linux"
    absent = [tool for tool in TOOLS if shutil.which(tool) is None]
    if not program("ansible-playbook").is_file():
        absent.append("ansible-playbook")
    return f"not installed here: {', '.join(absent)}" if absent else ""


def program(name: str) -> Path:
    """Path of a program beside this Python."""
    return Path(sys.executable).parent / name


@dataclass
class Run:
    """What a playbook answered: its text, its exit code, and its counts for the machine."""

    code: int
    text: str
    counts: dict[str, int]

    @property
    def changed(self) -> int:
        return self.counts["changed"]

    @property
    def changes(self) -> list[str]:
        """Names of the tasks that changed something."""
        tasks = self.text.replace("RUNNING HANDLER [", "TASK [").split("TASK [")[1:]
        return [task.split("]")[0] for task in tasks if "changed: [" in task]

    def why(self) -> str:
        """The message of the last task that failed, in one line."""
        parts = self.text.split("[ERROR]: Task failed: ")
        text = parts[-1].split("\nOrigin:")[0] if len(parts) > 1 else ""
        return " ".join(text.split())


class Machine:
    """One machine, from `start` to `stop`.

    Parameters
    ----------
    folder
        An empty folder of this session: keys, inventory, what is laid over the bare system.
    boot
        Files of its boot partition, by name.
    """

    def __init__(self, folder: Path, boot: dict[str, bytes] | None = None) -> None:
        self.folder = folder
        self.boot = boot or {}
        self.name = f"qrm{os.getpid()}"
        block, host = divmod(os.getpid() % 16000, 63)
        self.here, self.address = (f"169.254.{1 + block}.{4 * host + n}" for n in (1, 2))
        self.group = group_of_groups() / self.name
        self.log = folder / "boot.log"

    def start(self) -> None:
        """Boot it, and wait until systemd has started everything."""
        made = [str(HERE / "machine_build.sh"), RELEASE]
        base = subprocess.run(made, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
        self.group.mkdir()
        inside = ["ip", "-n", self.name]
        for command in (
            ["ip", "netns", "add", self.name],
            ["ip", "link", "add", self.name, "type", "veth", "peer", "eth0", "netns", self.name],
            ["ip", "address", "add", f"{self.here}/30", "dev", self.name],
            ["ip", "link", "set", self.name, "up"],
            [*inside, "address", "add", f"{self.address}/30", "dev", "eth0"],
            [*inside, "link", "set", "eth0", "up"],
        ):
            subprocess.run(command, check=True)
        self.proxy = serve(self.here, CACHE / "debs")
        self._lay_over()
        # unshare stays outside. It ends with this Python, and everything inside with it.
        command = ["nsenter", f"--net=/run/netns/{self.name}", "setpriv", "--pdeathsig", "KILL",
                   "unshare", "--mount", "--pid", "--uts", "--ipc", "--cgroup", "--fork",
                   "--kill-child", str(HERE / "machine_init.sh"), base,
                   str(self.folder)]  # fmt: skip
        enter = f'echo $$ >"{self.group}/cgroup.procs" && exec "$@"'
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                ["sh", "-c", enter, "sh", *command], stdout=log, stderr=log,
                stdin=subprocess.DEVNULL, start_new_session=True,
            )  # fmt: skip
        until(self._up, f"systemd and sshd do not come up, see {self.log}")

    def cut(self) -> None:
        """Cut its power: nothing of it answers any more, not even that a connection has ended."""
        subprocess.run(["ip", "link", "set", self.name, "down"], check=True)
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self) -> None:
        """End it: all its processes, its network and its files."""
        self.proxy.shutdown()
        self.proxy.server_close()
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        # At once: with its network alone it would go some time later, and the next machine of this
        # Python has the same name and address.
        subprocess.run(["ip", "link", "delete", self.name], check=True)
        subprocess.run(["ip", "netns", "delete", self.name], check=True)
        until(lambda: emptied(self.group), "the control group does not become empty")

    def _lay_over(self) -> None:
        """Write what makes the bare system this machine: its keys, and its boot partition."""
        more = self.folder / "more"
        (self.folder / "root").mkdir()
        key = self.folder / "key"
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key], check=True)
        files = {
            "etc/hostname": b"robot\n",
            # As after a first boot; at one, systemd would switch on sshd's socket too.
            "etc/machine-id": f"{uuid.uuid4().hex}\n".encode(),
            "etc/hosts": b"127.0.0.1 localhost robot\n",
            "etc/apt/apt.conf.d/00proxy":
                f'Acquire::http::Proxy "http://{self.here}:{self.proxy.server_port}";\n'.encode(),
            "home/pi/.ssh/authorized_keys": key.with_suffix(".pub").read_bytes(),
        }  # fmt: skip
        files |= {f"boot/firmware/{name}": text for name, text in self.boot.items()}
        (more / "etc/ssh").mkdir(parents=True)
        for name, content in files.items():
            path = more / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        subprocess.run(["ssh-keygen", "-q", "-A", "-f", more], check=True, stdout=subprocess.PIPE)
        for folder, _, names in os.walk(more):
            os.chmod(folder, 0o755)
            for path in [folder, *(os.path.join(folder, name) for name in names)]:
                if "/home/pi" in path:
                    os.chown(path, 1000, 1000)
        host_key = (more / "etc/ssh/ssh_host_ed25519_key.pub").read_text()
        names = f"{self.address},[{self.address}]:2222"
        (self.folder / "known_hosts").write_text(f"{names} {host_key}")

    def _up(self) -> bool:
        if self.process.poll() is not None:
            raise RuntimeError(f"the machine ended: {self.log.read_text()}")
        state = self.ssh("systemctl is-system-running")
        return state.stdout.strip() in ("running", "degraded")

    def ssh(
        self, command: str, check: bool = False, stdin: str = "", port: int = 22
    ) -> subprocess.CompletedProcess[str]:
        """Run a command on it as its first user; `check` wants it to succeed."""
        done = subprocess.run(
            ["ssh", "-q", "-o", f"UserKnownHostsFile={self.folder}/known_hosts",
             "-o", "BatchMode=yes", "-o", "ConnectTimeout=5", "-o", "IdentitiesOnly=yes",
             "-i", self.folder / "key", "-p", str(port), f"pi@{self.address}", command],
            input=stdin, capture_output=True, text=True, check=False, timeout=HANG,
        )  # fmt: skip
        assert not check or done.returncode == 0, (command, done.stdout, done.stderr)
        return done

    def root(self, command: str) -> str:
        """Output of a command that root runs on it, which must succeed."""
        quoted = command.replace("'", "'\\''")
        return self.ssh(f"sudo sh -c '{quoted}'", check=True).stdout

    def playbook(self, name: str, *options: str, inventory: str = "", **variables: Any) -> Run:
        """Run a playbook of the project as a person does, with real SSH.

        Parameters
        ----------
        name
            Such as ``provision.yml``; with a folder, one of other playbooks.
        options
            More for ansible-playbook.
        inventory
            Variables of the host in place of the key.
        variables
            Settings, as an inventory has them.
        """
        return playbook(self, name, *options, inventory=inventory, **variables)


def playbook(
    machine: Machine, name: str, *options: str, inventory: str = "", **variables: Any
) -> Run:
    """Run a playbook on a machine; see `Machine.playbook`."""
    folder = machine.folder
    key = f"ansible_user=pi ansible_ssh_private_key_file={folder}/key"
    known = f"-o UserKnownHostsFile={folder}/known_hosts"
    line = f"{NAME} ansible_host={machine.address} {inventory or key}"
    line += f" ansible_ssh_common_args='{known}'"
    (folder / "inventory.ini").write_text(line + "\n")
    settings = {
        "preflight_architectures": ["x86_64", "aarch64"],
        "qrobot_profile": "solver",
        "qrobot_compile": False,  # most of a minute for each release
        "qrobot_fetched": str(folder / "fetched"),
        "qrobot_wheelhouse": str(CACHE / "wheelhouse"),
        "base_debs": str(CACHE / "offline-debs"),
        "base_zram_percent": 0,  # swap would be the computer's
        **variables,
    }
    path = PLAYBOOKS / name
    times = folder / "times.json"
    times.unlink(missing_ok=True)
    done = subprocess.run(
        [program("ansible-playbook"), "--inventory", folder / "inventory.ini",
         "--extra-vars", json.dumps(settings), *options, path],
        env=os.environ | {"ANSIBLE_CONFIG": str(path.with_name("ansible.cfg")), "NO_COLOR": "1",
                          "ANSIBLE_NOCOLOR": "1", "QROBOT_TIMES": str(times), "COLUMNS": "400"},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=HANG, check=False,
    )  # fmt: skip
    hosts = json.loads(times.read_text())["hosts"] if times.exists() else {}
    empty = {"ok": 0, "changed": 0, "failures": 0, "unreachable": 0}
    return Run(done.returncode, done.stdout, hosts.get(NAME, empty))


def group_of_groups() -> Path:
    """Where control groups of version 2 are mounted."""
    for line in Path("/proc/self/mounts").read_text().splitlines():
        _, folder, kind, *_ = line.split()
        if kind == "cgroup2":
            return Path(folder)
    return Path("/sys/fs/cgroup")


def emptied(group: Path) -> bool:
    """Remove a control group and those in it; False while a process of it still ends."""
    try:
        for folder, _, _ in os.walk(group, topdown=False):
            os.rmdir(folder)
    except OSError:
        return False
    return True
