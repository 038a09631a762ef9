"""The modules as a playbook runs them: wheels sent, a release installed, used, and taken back."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from fleet_house import PLAYBOOK, SETTINGS
from release_house import PLUGINS, entry, lock, program, uv, wheel
from started import run

MARK = "RESULT "


class Play:
    """Runs tasks on this machine, in a root of its own."""

    pipelining = "0"  # as a robot's sudo may want it; 1 is faster

    def __init__(self, folder: Path) -> None:
        self.folder, self.root = folder, folder / "robot" / "opt"
        program("ansible-playbook")

    def __call__(self, *tasks: dict[str, Any], check: bool = False) -> tuple[list[Any], str]:
        """Run tasks; returns their results and all that was printed."""
        steps: list[dict[str, Any]] = [
            {**task, "register": f"r{number}", "ignore_errors": True}
            for number, task in enumerate(tasks)
        ]
        results = ", ".join(f"r{number}" for number in range(len(tasks)))
        steps.append({"ansible.builtin.debug": {"msg": f"{MARK}{{{{ [{results}] | to_json }}}}"}})
        play = {"hosts": "localhost", "connection": "local", "gather_facts": False, "tasks": steps}
        (self.folder / "play.yml").write_text(json.dumps([play]))
        # A short one: ansible-core 2.21 binds a socket in it, whose path may have 107 bytes.
        temporary = Path(tempfile.mkdtemp(prefix="q"))
        settings = SETTINGS | {
            "ANSIBLE_PYTHON_INTERPRETER": sys.executable,
            "ANSIBLE_REMOTE_TEMP": str(temporary),
            "ANSIBLE_PIPELINING": self.pipelining,
            "PATH": os.environ["PATH"],
            "HOME": str(self.folder),
            "TMPDIR": str(temporary),
        }
        words = ["-i", "localhost,", str(self.folder / "play.yml"), "--diff", *["--check"] * check]
        done = run(*words, folder=self.folder, environment=settings, program=PLAYBOOK, alone=True)
        printed = done.stdout + done.stderr
        found = re.findall(rf'"msg": "{MARK}(.*)"$', done.stdout, re.MULTILINE)
        assert len(found) == 1, printed
        left = [path.name for path in temporary.iterdir()]
        shutil.rmtree(temporary)
        assert left == [], "a temporary folder was left"
        told: list[Any] = json.loads(json.loads(f'"{found[0]}"'))
        assert len(told) == len(tasks)
        return told, printed

    def wheels(self, *files: dict[str, Any], **more: Any) -> dict[str, Any]:
        given = {"src": f"{self.folder}/wheels", "dest": f"{self.root}/wheels"}
        return {"qrobot_wheels": {**given, "files": list(files), **more}}

    def release(self, state: str, **more: Any) -> dict[str, Any]:
        return {"qrobot_release": {"root": str(self.root), "state": state, **more}}


@pytest.fixture
def play(tmp_path: Path) -> Play:
    return Play(tmp_path)


def changed(results: list[Any]) -> list[bool]:
    assert [r["msg"] for r in results if r.get("failed")] == []
    return [r["changed"] for r in results]


@pytest.mark.slow
def test_from_nothing_to_a_release_and_back(play: Play, tmp_path: Path) -> None:
    play.pipelining = "1"
    files = [wheel(tmp_path / "wheels", "tool", version) for version in ("1.0", "2.0")]

    def present(name: str, one: dict[str, Any]) -> list[dict[str, Any]]:
        more = {"uv": uv(), "python": sys.executable, "note": {"profile": "edge"}}
        made = play.release("present", id=name, requirements=lock(one), verify=True, **more)
        return [made, play.release("current", id=name)]

    tasks = [
        play.wheels(*files),
        *present("a", files[0]),
        *present("b", files[1]),
        play.release("verified"),
        play.release("pruned", keep=2),
    ]
    # In check mode, on a bare machine, b would also be switched to; nothing is written.
    assert changed(play(*tasks, check=True)[0]) == [True] * 5 + [False] * 2
    assert not play.root.parent.exists()

    results, _ = play(*tasks)
    assert changed(results) == [True] * 5 + [False] * 2
    assert results[3]["path"] == f"{play.root}/releases/b"
    assert (results[4]["current"], results[4]["previous"]) == ("b", "a")
    assert results[4]["releases"][0]["note"] == {"profile": "edge"}
    ran = subprocess.run([play.root / "current/bin/tool"], capture_output=True, text=True)
    assert f"{play.root}/releases/b" in ran.stdout

    again = [tasks[0], *tasks[3:]]
    assert changed(play(*again)[0]) == changed(play(*again, check=True)[0]) == [False] * 5

    next(play.root.glob("releases/b/lib/*/site-packages/tool.py")).unlink()
    back = [
        play.release("verified"),
        play.release("current", id="a.2"),
        play.release("absent", id="b"),
        play.release("rolled_back"),
        play.release("rolled_back"),
        play.release("absent", id="b"),
        play.release("status"),
        play.release("reset"),
    ]
    results, printed = play(*back)
    assert "tool.py is missing" in results[0]["msg"]
    assert "there is no release a.2" in results[1]["msg"]
    assert "is in use" in results[2]["msg"]
    assert (results[3]["id"], results[3]["current"]) == ("a", "a")
    assert "no earlier release" in results[4]["msg"]
    assert changed(results[5:]) == [True, False, True]
    assert [r["id"] for r in results[6]["releases"]] == ["a"]
    assert '-    "current": "b"' in printed
    assert '+    "current": "a"' in printed
    assert not play.root.exists()


@pytest.mark.slow
def test_only_what_is_missing_is_sent_in_chunks(play: Play, tmp_path: Path) -> None:
    source, dest = tmp_path / "wheels", play.root / "wheels"
    source.mkdir()
    for number in range(5):
        (source / f"w{number}-1.whl").write_bytes(os.urandom(400_000))
    files = [entry(path) for path in sorted(source.iterdir())]
    (source / "w4-1.whl").write_bytes(b"x" * 400_000)  # changed after it was verified

    (result,), printed = play(play.wheels(*files, chunk_mb=1))
    assert result["failed"]
    assert "w4-1.whl is not the file that was verified" in result["msg"]
    assert "wheels for localhost: 1 of 2 MB" in printed
    # The two chunks before it stay, whole and under their own names only.
    assert [entry(path) for path in sorted(dest.iterdir())] == files[:4]

    (dest / "w1-1.whl").write_bytes(b"y" * 400_000)
    files[4] = entry(source / "w4-1.whl")
    (result,), _ = play(play.wheels(*files, chunk_mb=1))
    assert (result["changed"], result["files"], result["chunks"]) == (True, 2, 1)
    assert result["msg"] == "2 files sent (0.8 MB)"
    assert [entry(path) for path in sorted(dest.iterdir())] == files
    (result,), _ = play(play.wheels(*files))
    assert (result["changed"], result["files"]) == (False, 0)


def test_what_arrives_is_verified(play: Play, tmp_path: Path) -> None:
    files = [wheel(tmp_path / "wheels", "tool", "1.0")]
    archive = tmp_path / "chunk.tar"
    subprocess.run(["tar", "-cf", archive, "-C", tmp_path / "wheels", files[0]["name"]], check=True)
    module = PLUGINS / "modules" / "qrobot_wheels.py"

    def unpack(*wanted: dict[str, Any]) -> str:
        given = {"state": "unpacked", "dest": str(tmp_path / "dest"), "archive": str(archive)}
        text = json.dumps({"ANSIBLE_MODULE_ARGS": {**given, "files": list(wanted)}})
        ansible = Path(program("ansible-playbook")).with_name("python")
        done = subprocess.run([ansible, module], input=text, capture_output=True, text=True)
        return str(json.loads(done.stdout).get("msg"))

    assert "tool-1.0-py3-none-any.whl did not arrive" in unpack({**files[0], "sha256": "0" * 64})
    assert "did not arrive" in unpack({**files[0], "size": 1})
    assert "was not announced" in unpack({**files[0], "name": "other.whl"})
    assert "give a plain file name" in unpack({**files[0], "name": "../tool.whl"})
    content = archive.read_bytes()
    archive.write_bytes(content[:700])
    assert "did not arrive as it was sent" in unpack(*files)
    assert list((tmp_path / "dest").iterdir()) == []
    archive.write_bytes(content)
    assert unpack(*files) == "None"
    assert [entry(path) for path in (tmp_path / "dest").iterdir()] == files
