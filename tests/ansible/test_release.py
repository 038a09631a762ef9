"""Releases: what is installed, switched, rolled back, pruned, and what every crash leaves."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from release_house import PLUGINS, entry, installed, load, lock, uv, wheel

release = load()
CASES = [
    "install",
    "first switch",
    "install over an unfinished one",
    "rebuild",
    "switch",
    "switch back",
    "discard",
    "reset",
    "rollback",
    "prune",
]


class Built(release.Releases):
    """Releases whose environments are three files: bookkeeping is tested, not uv."""

    def _build(self, target: Path, build: Path, requirements: str, *_: Any) -> None:
        (target / "lib").mkdir(parents=True)
        (target / "lib" / "tool.py").write_text("x = 1\n")
        (target / "requirements.txt").write_text(requirements)


def put(made: Any, *names: str, use: bool = True) -> None:
    for name in names:
        (made.root / "wheels").mkdir(parents=True, exist_ok=True)
        made.install(name, "tool==1.0", made.root / "wheels", "uv", "python")
        if use:
            made.switch(name)


@pytest.fixture
def made(tmp_path: Path) -> Built:
    return Built(tmp_path / "root")


# With the real installer


def real(tmp_path: Path, requirements: str, name: str = "1.0-edge-abc") -> tuple[Any, Any]:
    made = release.Releases(tmp_path / "root")
    return made, made.install(name, requirements, tmp_path / "wheels", uv(), sys.executable)


def test_two_releases_run_by_their_own_files_and_share_none(tmp_path: Path) -> None:
    one = wheel(tmp_path / "wheels", "tool", "1.0")
    two = wheel(tmp_path / "wheels", "other", "2.0")
    made, answer = real(tmp_path, lock(one, two), "a")
    assert answer == ("a", True)
    real(tmp_path, lock(one), "b")
    for name in "ab":
        made.switch(name)
        done = subprocess.run([made.current / "bin" / "tool"], capture_output=True, text=True)
        assert str(made.folder / name) in done.stdout
        assert made.verify(name) == {"count": 0, "differences": []}
    assert not (made.folder / "b/bin/other").exists()
    files = [p for p in made.folder.rglob("*") if p.is_file() and not p.is_symlink()]
    assert any(p.suffix == ".pyc" for p in files)
    assert [p for p in files if p.stat().st_nlink > 1] == []
    assert [p for p in files if p.stat().st_mode & 0o022] == []
    assert real(tmp_path, lock(one), "b")[1] == ("b", False)


def broken(tmp_path: Path) -> dict[str, Any]:
    path = tmp_path / "wheels" / wheel(tmp_path / "wheels", "other", "2.0")["name"]
    path.write_bytes(path.read_bytes()[:300])
    return entry(path)


@pytest.mark.parametrize(
    ("made_wrong", "says"),
    [
        (lambda p: {**wheel(p / "wheels", "other", "2.0"), "sha256": "0" * 64}, "Hash mismatch"),
        (broken, "other-2.0-py3-none-any.whl"),
        (lambda p: {"name": "absent-1.0-x", "sha256": "0" * 64}, "absent was not found"),
    ],
)
def test_a_wrong_wheel_leaves_nothing_and_the_old_release_in_use(
    tmp_path: Path, made_wrong: Any, says: str
) -> None:
    good = wheel(tmp_path / "wheels", "tool", "1.0")
    made, _ = real(tmp_path, lock(good), "a")
    made.switch("a")
    with pytest.raises(release.ReleaseError, match=says) as raised:
        real(tmp_path, lock(good, made_wrong(tmp_path)), "b")
    assert "\n" not in str(raised.value)
    assert sorted(p.name for p in made.root.iterdir()) == [
        ".lock",
        "current",
        "history.json",
        "releases",
    ]
    assert made.status()["current"] == "a"
    assert [r["id"] for r in made.status()["releases"]] == ["a"]


def test_a_full_disk_is_one_sentence(tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    if (
        os.geteuid()
        or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=200k", "none", disk], capture_output=True
        ).returncode
    ):
        pytest.skip("a small file system cannot be mounted: needs root")
    try:
        one = wheel(tmp_path / "wheels", "tool", "1.0", f"x = '{os.urandom(200_000).hex()}'\n")
        made = release.Releases(disk / "root")
        with pytest.raises(release.ReleaseError, match=r"No space left on device.*make room$"):
            made.install("a", lock(one), tmp_path / "wheels", uv(), sys.executable)
        assert made.status()["releases"] == []
    finally:
        subprocess.run(["umount", disk], check=True)


# Bookkeeping


@pytest.mark.parametrize("case", CASES)
def test_a_kill_at_any_step_leaves_a_state_that_the_next_run_completes(case: str) -> None:
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        program = Path(__file__).with_name("release_crash.py")
        done = subprocess.run(
            [sys.executable, program, case, folder],
            env=os.environ | {"PYTHONPATH": str(PLUGINS / "module_utils")},
            capture_output=True,
            text=True,
        )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    before, after = found["before"], found["after"]
    assert before != after
    assert len(found["kills"]) >= 10
    for kill in found["kills"]:
        left = kill["left"]
        assert not left["dangles"], kill
        # As before or as after, current and previous together; a rebuild passes no third state.
        pair = (left["current"], left["previous"])
        assert pair in [(s["current"], s["previous"]) for s in (before, after)], kill
        for name, damage in left["damage"].items():
            assert damage == before["damage"].get(name, 0), kill
        assert kill["mended"] == after, kill


class Model(RuleBasedStateMachine):
    """Any sequence of operations against lists of names."""

    names = st.sampled_from("abcdef")

    @initialize()
    def begin(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.made = Built(Path(self.folder.name) / "root")
        self.there: list[str] = []  # in the sequence of their installation
        self.used: list[str] = []  # every switch
        self.undo: list[str] = []  # what rollbacks go back along; the last is current
        self.damaged: set[str] = set()

    def teardown(self) -> None:
        if hasattr(self, "folder"):
            self.folder.cleanup()

    def earlier(self) -> list[str]:
        return [n for n in reversed(self.undo[:-1]) if n in self.there and n != self.undo[-1]]

    @rule(name=names)
    def install(self, name: str) -> None:
        put(self.made, name, use=False)
        if name not in self.there:
            self.there.append(name)

    @rule(name=names)
    def switch(self, name: str) -> None:
        if name not in self.there:
            with pytest.raises(release.ReleaseError, match="there is no release"):
                self.made.switch(name)
            return
        assert self.made.switch(name) == (self.undo[-1:] != [name])
        if self.undo[-1:] != [name]:
            self.used.append(name)
            self.undo.append(name)

    @rule(name=names)
    def damage(self, name: str) -> None:
        if name in self.there and name not in self.undo[-1:]:
            (self.made.folder / name / "lib" / "tool.py").write_text("")
            self.damaged.add(name)

    @rule()
    def rollback(self) -> None:
        whole = [name for name in self.earlier() if name not in self.damaged]
        if not whole:
            with pytest.raises(release.ReleaseError):
                self.made.rollback()
            return
        assert self.made.rollback() == whole[0]
        self.used.append(whole[0])
        self.undo.pop()
        while self.undo[-1] != whole[0]:
            self.undo.pop()

    @rule(keep=st.integers(1, 4))
    def prune(self, keep: int) -> None:
        kept = {*self.undo[-1:], *self.earlier()[:1]}
        newest = sorted(self.there, key=self.there.index, reverse=True)
        newest = [n for n in newest if n not in self.used] + sorted(
            (n for n in self.there if n in self.used),
            key=lambda n: -max(i for i, u in enumerate(self.used) if u == n),
        )
        for name in newest:
            if len(kept) < keep:
                kept.add(name)
        gone = set(self.there) - kept
        assert set(self.made.prune(keep)) == {f"releases/{name}" for name in gone}
        self.there = [name for name in self.there if name in kept]
        self.damaged -= gone

    @rule(name=names)
    def discard(self, name: str) -> None:
        if self.undo[-1:] == [name]:
            with pytest.raises(release.ReleaseError, match="is in use"):
                self.made.discard(name)
        else:
            assert self.made.discard(name) == (name in self.there)
            self.there = [n for n in self.there if n != name]
            self.damaged.discard(name)

    @invariant()
    def agrees(self) -> None:
        state = self.made.status(verify=True)
        assert state["current"] == (self.undo[-1] if self.undo else None)
        assert state["previous"] == next(iter(self.earlier()), None)
        assert {r["id"]: r["damaged"] for r in state["releases"]} == {
            name: name in self.damaged for name in self.there
        }
        if self.undo and self.undo[-1] not in self.damaged:
            assert (self.made.current / "lib" / "tool.py").read_text() == "x = 1\n"


Model.TestCase.settings = settings(max_examples=25, stateful_step_count=20, deadline=None)
TestModel = Model.TestCase


def test_a_damaged_release_in_use_is_built_again_beside_it(made: Built) -> None:
    put(made, "old", "a")
    tool = made.folder / "a" / "lib" / "tool.py"
    tool.unlink()
    assert made.verify("a") == {"count": 1, "differences": ["lib/tool.py is missing"]}
    wheels = made.root / "wheels"
    assert made.install("a", "tool==1.0", wheels, "uv", "python") == ("a", False)
    again = made.install("a", "tool==1.0", wheels, "uv", "python", verify=True)
    assert again == ("a.2", True)
    assert made.current_id() == "a"
    assert made.switch("a.2")
    assert made.install("a", "", wheels, "uv", "python", verify=True) == ("a.2", False)
    assert made.status()["previous"] == "old"  # not the damaged one
    assert made.prune() == ["releases/a"]


def test_what_changed_is_named_up_to_twenty(made: Built) -> None:
    put(made, "a")
    folder = made.folder / "a"
    os.utime(folder / "lib" / "tool.py", ns=(1, 1))
    (folder / "lib" / "__pycache__").mkdir()
    (folder / "lib" / "__pycache__" / "tool.pyc").write_text("new")
    assert made.verify("a")["differences"] == ["lib/tool.py was changed"]
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["links"] = {f"bin/p{i}": "python" for i in range(30)}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    found = made.verify("a")
    assert (found["count"], len(found["differences"])) == (31, 20)


def test_without_room_nothing_is_touched(made: Built) -> None:
    put(made, "a")
    free = shutil.disk_usage(made.root).free // 1_000_000
    with pytest.raises(release.ReleaseError, match=r"\d+ MB are free .* takes \d+ MB and 5 MB"):
        made.install("b", "", made.root / "wheels", "uv", "python", None, free + 10_000, 5)
    assert [r["id"] for r in made.status()["releases"]] == ["a"]


def test_a_second_run_is_refused_while_one_works(made: Built) -> None:
    put(made, "a", "b")
    with open(made.root / ".lock") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        for act in (made.rollback, made.prune, made.reset, lambda: made.switch("a")):
            with pytest.raises(release.ReleaseError, match="another run works"):
                act()
        assert made.status()["current"] == "b"
    assert made.rollback() == "a"


def test_reset_leaves_what_is_not_ours(made: Built, tmp_path: Path) -> None:
    put(made, "a")
    (made.root / "photos").mkdir()
    with pytest.raises(release.ReleaseError, match="also holds photos"):
        made.reset()
    assert made.current_id() == "a"
    (made.root / "photos").rmdir()
    assert made.reset()
    assert not made.root.exists()
    assert not made.reset()
    with pytest.raises(release.ReleaseError, match="not a folder of releases"):
        release.Releases("/").reset()


def test_prune_removes_wheels_that_no_kept_release_names(made: Built) -> None:
    wheels = made.root / "wheels"
    names = ["my_Tool-1.0.0-py3-none-any.whl", "my_Tool-1.1-py3-none-any.whl", "readme.txt"]
    wheels.mkdir(parents=True)
    for name in [*names, ".x.whl.part"]:
        (wheels / name).write_text("")
    made.install("a", "my-tool[all]==1.0 \\\n  --hash=sha256:00\n", wheels, "uv", "python")
    made.switch("a")
    assert made.prune() == ["wheels/.x.whl.part", f"wheels/{names[1]}"]


@pytest.mark.parametrize("name", ["", "..", "a/b", "-x", ".a", "a b", "x" * 81])
def test_an_id_is_no_path(made: Built, name: str) -> None:
    put(made, "a")
    for act in (made.switch, made.discard, made.verify):
        with pytest.raises(release.ReleaseError, match="not an ID") as raised:
            act(name)
        assert raised.value.code == 2


def test_the_program(made: Built, tmp_path: Path) -> None:
    program = installed(tmp_path / "program")

    def run(*words: str) -> tuple[int, str]:
        command = [sys.executable, "-IB", program, *words, "--root", made.root]
        done = subprocess.run(command, capture_output=True, text=True)
        assert "Traceback" not in done.stderr
        return done.returncode, done.stdout + done.stderr

    assert run("verify")[0] == 1
    put(made, "a", "b")
    assert run("verify") == (0, "b: every file is as installed\n")
    assert json.loads(run("list", "--json")[1])["previous"] == "a"
    assert run("rollback") == (0, "in use: a\n")
    assert run("rollback")[0] == 1
    assert run("switch", "c")[0] == run("prune", "--keep", "0")[0] == run("nonsense")[0] == 2
    assert run("switch", "b") == (0, "in use: b\n")
    (made.folder / "b" / "lib" / "tool.py").unlink()
    assert run("verify") == (1, "lib/tool.py is missing\n")
    help_text = subprocess.run(
        [sys.executable, "-IB", program, "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert "sudo qrobot-release rollback" in help_text
