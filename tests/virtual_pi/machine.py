"""The virtual Pi in the hands of a program: boot it, play on it, cut its power, look inside."""

from __future__ import annotations

import base64
import http.client
import json
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from processes import until
from virtual_pi import fat
from virtual_pi.rfb import first_frame
from virtual_pi.wheels import build, rewritten

COUNT = re.compile(r"(ok|changed|unreachable|failed|skipped)=(\d+)")
SAMPLE = """
import glob, select, sys
needles = [word.encode() for word in sys.stdin.readline().split()]
while not select.select([sys.stdin], [], [], 0.1)[0]:  # until the connection ends
    for name in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            text = open(name, "rb").read()
        except OSError:
            continue
        if any(needle in text for needle in needles):
            print(text.split(bytes(1))[0].decode(), flush=True)
"""

SEARCH = """
import os, sys
needles = [word.encode() for word in sys.stdin.readline().split()]
for top in sys.stdin.readline().split():
    for folder, folders, names in os.walk(top):
        for name in names:
            path = os.path.join(folder, name)
            if os.path.islink(path) or not os.path.isfile(path):
                continue
            try:
                text = open(path, "rb").read()
            except OSError:
                continue
            if any(needle in text for needle in needles):
                print(path)
"""


@dataclass
class Run:
    """What a playbook did: its exit code, its words, its counts and its times."""

    code: int
    output: str
    counts: dict[str, int]
    seconds: float
    roles: dict[str, float]
    slowest: list[dict[str, Any]]

    def tail(self) -> str:
        """The sentences of what failed, or the last lines."""
        lines = [line.strip() for line in self.output.splitlines() if line.strip()]
        bad = [line for line in lines if line.startswith(("fatal:", "[ERROR]", "msg:"))]
        return " / ".join((bad or lines)[-4:])[:1200]


@dataclass
class Reached:
    ok: bool
    why: str = ""


class Proof:
    """What was measured and what held, on the disk after every step."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.data: dict[str, Any] = json.loads(path.read_text()) if path.exists() else {}
        self.failed: list[str] = []

    def __setitem__(self, name: str, value: Any) -> None:
        self.data[name] = value
        self._write()
        if isinstance(value, str | int | float):
            print(f"   {name}: {value}", flush=True)

    def __getitem__(self, name: str) -> Any:
        return self.data[name]

    def get(self, name: str) -> Any:
        return self.data.get(name)

    def hold(self, what: str, held: bool, why: str = "") -> None:
        """Note whether something held; the run goes on either way."""
        print(f"   {'ok  ' if held else 'FAIL'} {what}{'' if held else ': ' + why}", flush=True)
        self.data.setdefault("held", {})[what] = held
        if not held:
            self.failed.append(f"{what}: {why}")
        self._write()

    def _write(self) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.data, indent=1) + "\n")


def listens(port: int) -> bool:
    """Tell whether something takes connections at a port of this computer's loopback."""
    with socket.socket() as asked:
        return asked.connect_ex(("127.0.0.1", port)) == 0


class Machine:
    NEXT = "9.0.1"
    BROKEN = "9.0.2"

    def __init__(self, root: Path, folder: Path) -> None:
        self.root, self.folder = root, folder
        folder.mkdir(parents=True, exist_ok=True)
        self.script = root / "ansible/virtual-pi/virtual-pi.sh"
        self.environment = {**os.environ, "VPI_DIR": str(folder)}
        self.environment["ANSIBLE_CONFIG"] = str(root / "ansible/ansible.cfg")
        self.environment["PYTHONUNBUFFERED"] = "1"
        self.profile = os.environ.get("VPI_PROFILE", "edge")
        self.wheel = build(root, folder / "wheels")

    # --- power -----------------------------------------------------------------------------------

    def _script(self, *words: str, **more: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [self.script, *words], env={**self.environment, **more}, check=True, text=True
        )

    def start(self, network: str = "") -> float:
        begin = time.monotonic()
        self._script("start", VPI_NETWORK=network)
        return round(time.monotonic() - begin, 1)

    def reset(self) -> None:
        self._script("reset")

    def restart(self) -> None:
        """Shut it down and boot it again, with a network."""
        self._script("stop")
        self.start()

    def kill(self) -> None:
        self._script("kill")

    # --- looking inside --------------------------------------------------------------------------

    def ssh(self, command: str) -> str:
        return subprocess.run(
            [self.script, "ssh", command],
            env=self.environment, check=True, text=True, capture_output=True,
        ).stdout  # fmt: skip

    def listing(self) -> str:
        """Every file that provisioning could touch, with size, mode and time."""
        return self.ssh(
            "sudo find /etc /opt /usr/local /var/lib/qrobot* /boot/firmware -type f "
            "-printf '%p %s %m %T@\\n' 2>/dev/null | sort"
        )

    def report(self) -> dict[str, Any]:
        name = self.ssh("readlink /opt/qrobot/current").strip().rsplit("/", 1)[-1]
        report: dict[str, Any] = json.loads(self.ssh(f"cat /var/lib/qrobot-health/{name}.json"))
        return report

    def watch(self, needles: list[str]) -> Callable[[], list[str]]:
        """Sample the process list for words until the function returned is called."""
        sampler = subprocess.Popen(
            [self.script, "ssh", f"sudo python3 -c {shlex.quote(SAMPLE)}"],
            env=self.environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            start_new_session=True,
        )  # fmt: skip
        assert sampler.stdin is not None
        sampler.stdin.write(" ".join(needles) + "\n")
        sampler.stdin.flush()

        def stop() -> list[str]:
            assert sampler.stdin is not None
            seen, _ = sampler.communicate()  # it ends when its input does
            return sorted(set(seen.split("\n")) - {""})

        return stop

    def search(self, needles: list[str], folders: str) -> list[str]:
        """Return the files that hold a word; it goes there by a pipe: sudo logs its arguments."""
        return subprocess.run(
            [self.script, "ssh", f"sudo python3 -c {shlex.quote(SEARCH)}"],
            env=self.environment, check=True, text=True, capture_output=True,
            input=f"{' '.join(needles)}\n{folders}\n",
        ).stdout.split()  # fmt: skip

    def fat_cuts(self, module: str, files: dict[str, list[str]]) -> tuple[int, list[str]]:
        """Cut the power of a FAT disk of the machine's while the module replaces files (fat.py)."""
        guest = Path(__file__).with_name("fat_guest.py").read_text()
        begin = fat.disk(files, self.folder)
        image = base64.b64encode(zlib.compress(begin)).decode()
        told = subprocess.run(
            [self.script, "ssh", f"sudo python3 -c {shlex.quote(guest)}"],
            env=self.environment, check=True, text=True, capture_output=True,
            input=json.dumps({"source": module, "image": image, "files": files}),
        ).stdout  # fmt: skip
        return fat.cuts(begin, json.loads(told)["runs"], files, self.folder)

    @contextmanager
    def tunnel(self, port: int) -> Iterator[int]:
        """Forward a port of the machine's loopback, as a person does with ssh -L."""
        here = 5942
        command = [self.script, "ssh", "-N", "-L", f"127.0.0.1:{here}:127.0.0.1:{port}"]
        child = subprocess.Popen(command, env=self.environment, start_new_session=True)
        try:
            until(lambda: listens(here) or child.poll() is not None, "a tunnel")
            yield here
        finally:
            os.killpg(child.pid, signal.SIGTERM)
            child.wait()

    def answer(self, port: int, path: str, token: str) -> int:
        """Ask a page of the machine's loopback through the tunnel; returns the status."""
        with self.tunnel(port) as here:
            asked = http.client.HTTPConnection("127.0.0.1", here, timeout=120)
            asked.request("GET", path, headers={"Authorization": f"token {token}"} if token else {})
            return asked.getresponse().status

    def frame(self) -> dict[str, Any]:
        frame: dict[str, Any] = {"colours": 0}

        def shown() -> bool:  # emulated, wayvnc and the terminal on it take seconds to start
            with self.tunnel(5900) as port, suppress(ConnectionError):
                frame.update(first_frame("127.0.0.1", port, self.folder / "frame.png"))
            return bool(frame["colours"] > 1)

        until(shown, "a frame with a terminal on it")
        return frame

    # --- wheels ----------------------------------------------------------------------------------

    def next_wheel(self) -> Path:
        """The same qRobot under a later version."""
        return rewritten(self.wheel, self.folder / "next", self.NEXT, lambda _, data: data)

    def broken_wheel(self) -> Path:
        """A later version whose exact solver cannot be imported."""

        def spoil(name: str, data: bytes) -> bytes:
            if name != "qrobot/backends/classical/exact/__init__.py":
                return data
            return b"raise ImportError('planted: this wheel is broken')\n"

        return rewritten(self.wheel, self.folder / "broken", self.BROKEN, spoil)

    # --- playing ---------------------------------------------------------------------------------

    def _command(self, playbook: str, words: tuple[str, ...]) -> list[str]:
        command = [
            str(Path(sys.prefix) / "bin/ansible-playbook"), "--inventory",
            str(self.folder / "inventory.yml"), str(self.root / f"ansible/{playbook}.yml"),
            "-e", f"qrobot_fetched={self.folder / 'fleet'}",
        ]  # fmt: skip
        if not any("qrobot_wheel=" in word for word in words):
            command += ["-e", f"qrobot_wheel={self.wheel}"]
        if not any("qrobot_profile=" in word for word in words):
            command += ["-e", f"qrobot_profile={self.profile}"]
        return [*command, *words]

    def play(self, playbook: str, *words: str) -> Run:
        times = self.folder / "times.json"
        times.unlink(missing_ok=True)
        begin = time.monotonic()
        done = subprocess.run(
            self._command(playbook, words), text=True, check=False, cwd=self.root,
            env={**self.environment, "QROBOT_TIMES": str(times)},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        seconds = round(time.monotonic() - begin, 1)
        log = self.folder / "logs"
        log.mkdir(exist_ok=True)
        stamp = time.strftime("%H%M%S")
        (log / f"{stamp}-{playbook}.log").write_text(" ".join(words) + "\n" + done.stdout)
        recap = done.stdout.rpartition("PLAY RECAP")[2]
        found = {name: int(count) for name, count in COUNT.findall(recap)}
        counts = {name: found.get(name, -1) for name in ("changed", "failed", "unreachable")}
        told = json.loads(times.read_text()) if times.exists() else {"roles": {}, "slowest": []}
        print(
            f"   {playbook} {' '.join(words)}: {seconds} s, exit code {done.returncode}, {counts}"
        )
        return Run(done.returncode, done.stdout, counts, seconds, told["roles"], told["slowest"])

    def cut_during(self, playbook: str, task: str, delay: float, *words: str) -> Reached:
        """Play until a task has begun, and cut the power at a moment after it, whatever it does."""
        child = subprocess.Popen(
            self._command(playbook, words), text=True, cwd=self.root, env=self.environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        assert child.stdout is not None
        lines = []
        for line in child.stdout:
            lines.append(line.strip())
            if line.startswith((f"TASK [{task}", f"RUNNING HANDLER [{task}")):
                time.sleep(delay)
                alive = child.poll() is None
                self.kill()
                os.killpg(child.pid, signal.SIGKILL)
                child.wait()
                return Reached(alive, "the run had ended before")
        child.wait()
        return Reached(False, " / ".join(line for line in lines[-8:] if line))
