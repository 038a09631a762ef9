"""Kills an operation on releases at every step, and writes down what each kill left.

Run as a program: ``release_crash.py CASE FOLDER``. Steps are the calls that change the disk, and
each is counted twice, before and after. The kill is also a power cut: a file whose content no fsync
or sync has put on the disk is emptied, which is what a journalling file system may leave of it.
Output: JSON, one record for each kill, and the state that an undisturbed run leaves.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from release_house import load, lock, wheel

STEPS = ("replace", "rename", "unlink", "rmdir", "mkdir", "symlink", "fsync", "sync")
release = load()
os.sync = os.fsync = lambda *_: None  # what they promise is kept by Power; the real ones are slow


def build(self: Any, target: Path, cache: Path, requirements: str, *_: Any) -> None:
    """Stand in for uv, which takes a second: several hundred installs are interrupted here."""
    (target / "lib").mkdir(parents=True)
    (target / "lib64").symlink_to("lib")
    (target / "requirements.txt").write_text(requirements)
    (cache / "unpacked.py").write_text("x = 1\n")
    subprocess.run(["true"], check=True)
    os.link(cache / "unpacked.py", target / "lib" / "tool.py")


def rmtree(folder: Path, **_: Any) -> None:
    """Delete a folder in the worst sequence: what says that it is complete goes last."""
    for path in sorted(Path(folder).iterdir(), key=lambda p: (p.name == "manifest.json", p.name)):
        if path.is_dir() and not path.is_symlink():
            rmtree(path)
        else:
            os.unlink(path)
    os.rmdir(folder)


release.Releases._build = build
really_remove, shutil.rmtree = shutil.rmtree, rmtree


class Power:
    """Counts steps, and cuts the power at one of them."""

    def __init__(self, root: Path, at: int) -> None:
        self.root, self.at, self.count = root, at, 0
        self.synced = {path.lstat().st_ino for path in root.rglob("*")}
        for name in STEPS:
            setattr(os, name, self.counted(name, getattr(os, name)))
        subprocess.run = self.counted("run", subprocess.run)

    def counted(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any, **more: Any) -> Any:
            self.step(f"before {name}")
            answer = real(*given, **more)
            if name == "fsync":
                self.synced.add(os.fstat(given[0]).st_ino)
            elif name == "sync":
                self.synced |= {path.lstat().st_ino for path in self.root.rglob("*")}
            self.step(f"after {name}")
            return answer

        return call

    def step(self, label: str) -> None:
        self.count += 1
        if self.count != self.at:
            return
        for path in self.root.rglob("*"):
            if path.is_file() and not path.is_symlink() and path.stat().st_ino not in self.synced:
                os.truncate(path, 0)
        (self.root.parent / "label").write_text(label)
        os.kill(os.getpid(), signal.SIGKILL)


class House:
    """A root with tiny releases, and the operations on it."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "root"
        self.wheels = self.root / "wheels"
        self.lock = {n: lock(wheel(self.wheels, "tool", f"{i}.1")) for i, n in enumerate("abcd", 1)}

    def install(self, *names: str, verify: bool = False) -> None:
        for name in names:
            made = release.Releases(self.root)
            made.install(name, self.lock[name], self.wheels, "uv", sys.executable, verify=verify)

    def switch(self, *names: str) -> None:
        for name in names:
            release.Releases(self.root).switch(name)

    def unfinished(self, name: str) -> None:
        folder = self.root / "releases" / name / "lib"
        folder.mkdir(parents=True)
        (folder / "half.py").write_text("x =")

    def prepare(self, case: str) -> Callable[[], Any]:
        """Bring the root to where the case begins; returns what is then interrupted."""
        made = release.Releases(self.root)
        if case == "install":
            return lambda: self.install("a")
        self.install("a")
        if case == "first switch":
            return lambda: self.switch("a")
        self.switch("a")
        if case == "install over an unfinished one":
            self.unfinished("b")
            return lambda: self.install("b")
        if case == "rebuild":
            (self.root / "releases/a/lib/tool.py").write_text("")
            return lambda: (self.install("a", verify=True), self.switch("a.2"))
        self.install("b")
        if case == "switch":
            return lambda: self.switch("b")
        if case == "discard":
            return lambda: made.discard("b")
        self.switch("b")
        if case == "switch back":
            return lambda: self.switch("a")
        if case == "reset":
            return made.reset
        self.install("c")
        self.switch("c")
        if case == "rollback":
            return made.rollback
        assert case == "prune"
        self.unfinished("d")
        return lambda: made.prune(2)


def state(root: Path) -> dict[str, Any]:
    """What a run that comes later finds, with the damage of every complete release."""
    made = release.Releases(root)
    found = made.status()
    link = root / "current"
    return {
        "current": found["current"],
        "previous": found["previous"],
        "complete": sorted(r["id"] for r in found["releases"] if r["complete"]),
        "damage": {
            r["id"]: made.verify(r["id"])["count"] for r in found["releases"] if r["complete"]
        },
        "dangles": link.is_symlink() and not (link / "manifest.json").is_file(),
        "there": root.exists(),
        "wheels": sorted(p.name for p in root.glob("wheels/*")),
    }


def main() -> None:
    case, folder = sys.argv[1], Path(sys.argv[2])
    house = House(folder)
    act = house.prepare(case)
    saved = folder / "saved"
    shutil.copytree(house.root, saved, symlinks=True)
    before, records = state(house.root), []
    for at in range(1, 10_000):
        really_remove(house.root, ignore_errors=True)
        shutil.copytree(saved, house.root, symlinks=True)
        child = os.fork()
        if child == 0:
            Power(house.root, at)
            act()
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if not os.WIFSIGNALED(status):
            assert os.WEXITSTATUS(status) == 0, f"step {at}: the operation itself failed"
            break
        record = {"at": at, "label": (folder / "label").read_text(), "left": state(house.root)}
        # A rollback that came through is not repeated: it would go one further.
        if case != "rollback" or record["left"]["current"] == before["current"]:
            act()
        record["mended"] = state(house.root)
        records.append(record)
    print(json.dumps({"before": before, "after": state(house.root), "kills": records}))


if __name__ == "__main__":
    main()
