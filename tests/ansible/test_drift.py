"""Drift: what robots are held against, and how it is told."""

from __future__ import annotations

import json
import platform
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fleet_house import ANSIBLE, DEAD, LOCAL, play, robot
from release_house import program

from qrobot import __version__

PROGRAM = ANSIBLE / "controller/drift.py"
HASH = f"    --hash=sha256:{'0' * 64}\n"
LOCK = (
    f"alpha==1.0 \\\n{HASH}Beta_Two[extra]==2.0 ; platform_machine == 'aarch64' \\\n{HASH}"
    f"gamma==3.0 ; platform_machine == 'x86_64' \\\n{HASH}"
    f"delta==4.0 ; python_full_version < '3.12' \\\n{HASH}"
)
# By hand: what LOCK pins for aarch64 and Python 3.13.
PINNED = {"alpha": "1.0", "beta-two": "2.0", "qrobot": __version__}
ID = f"{__version__}-solver-0011aabb"


def one(name: str, profile: str = "solver", why: str = "", **changes: Any) -> dict[str, Any]:
    """A robot as the playbook writes it down: without a change, there is no drift."""
    seen: dict[str, Any] = {
        "release": {
            "id": ID.replace("solver", profile),
            "base": ID.replace("solver", profile),
            "previous": None,
            "damage": {"count": 0, "differences": []},
        },
        "packages": PINNED,
        "python": "3.13",
        "machine": "aarch64",
        "codename": "trixie",
        "kernel": "6.12.25+rpt-rpi-v8",
        "firmware": None,
        "files": {"/etc/nftables.conf": "a" * 64},
        "units": {"nftables.service": {"enabled": "enabled", "active": "active"}},
        "reboot": [],
        "apt": None,
    }
    settings = {"profile": profile, "lock": ""}
    inventory = None if why else seen | changes
    return {"name": name, "settings": settings, "why": why, "inventory": inventory}


class Program:
    """The program of the controller, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("locks", "wheelhouse"):
            (folder / name).mkdir()
        for name in ("solver.txt", "edge.txt", "full.txt"):
            (folder / "locks" / name).write_text(LOCK)

    def __call__(
        self, *robots: dict[str, Any], schema: str = "qrobot.inventory/1"
    ) -> tuple[int, str]:
        inventory = self.folder / "inventory.json"
        inventory.write_text(json.dumps({"schema": schema, "robots": robots}))
        return self.run(inventory)

    def run(self, inventory: Path) -> tuple[int, str]:
        options = [f"--{name}={self.folder / name}" for name in ("locks", "wheelhouse")]
        command = [sys.executable, str(PROGRAM), str(inventory), *options, f"--dest={self.folder}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert "Traceback" not in done.stderr
        return done.returncode, done.stdout + done.stderr

    def told(self) -> dict[str, dict[str, Any]]:
        document = json.loads((self.folder / "drift.json").read_text())
        assert document["schema"] == "qrobot.drift/1"
        return {entry["name"]: entry for entry in document["robots"]}


@pytest.fixture
def drift(tmp_path: Path) -> Program:
    return Program(tmp_path)


def test_robots_that_are_as_the_lock_says_have_no_drift(drift: Program) -> None:
    spelled = PINNED | {"alpha": "1.0.0"}  # the same version
    code, said = drift(one("a"), one("b", packages=spelled), one("c", "edge"))
    assert code == 0, said
    assert [entry["state"] for entry in drift.told().values()] == ["same"] * 3
    assert said.splitlines()[-1] == "3 robots: 3 without drift"


def test_every_difference_from_the_lock_is_named(drift: Program) -> None:
    has = {"alpha": "1.1", "gamma": "3.0", "qrobot": __version__}
    code, said = drift(one("a"), one("b", packages=has))
    assert code == 1
    assert drift.told()["b"]["packages"] == {
        "missing": {"beta-two": "2.0"},
        "extra": {"gamma": "3.0"},
        "other": {"alpha": {"has": "1.1", "lock": "1.0"}},
    }
    assert drift.told()["a"]["state"] == "same"
    assert "b: 1 package missing (beta-two)" in said
    # The same packages are right on another machine and Python: markers count.
    there = {"alpha": "1.0", "gamma": "3.0", "delta": "4.0", "qrobot": __version__}
    alone = one("x", packages=there, machine="x86_64", python="3.11")
    assert drift(alone)[0] == 0


def test_the_release_is_the_one_that_this_checkout_would_install(drift: Program) -> None:
    older = {"id": "0.0.1-solver-99", "base": "0.0.1-solver-99", "previous": None}
    whole = {"count": 0, "differences": []}
    again = {**older, "id": f"{ID}.2", "base": ID, "damage": whole}
    robots = (
        one("old", release={**older, "damage": whole}),
        one("again", release=again),
        one("torn", release={**again, "damage": {"count": 2, "differences": ["x is missing"]}}),
        one("bare", release=None, packages={}),
    )
    collected = drift.folder / "wheelhouse/solver-3.13-aarch64.json"
    for id_, pins, wanted in (
        (None, PINNED, f"{__version__}-solver-"),  # nothing collected: version and profile
        (ID, PINNED, ID),
        ("0.0.1-solver-99", PINNED, f"{__version__}-solver-"),  # of an older version
        (
            ID.replace("00", "ff"),
            PINNED | {"alpha": "0.9"},  # of an older lock
            f"{__version__}-solver-",
        ),
        (ID.replace("00", "ff"), PINNED, ID.replace("00", "ff")),
    ):
        if id_:
            # As wheelhouse.py writes it: a line each, for one machine, with qRobot's own wheel.
            text = "".join(f"{name}=={version} {HASH.strip()}\n" for name, version in pins.items())
            collected.write_text(json.dumps({"id": id_, "requirements": text}))
        assert drift(*robots)[0] == 1
        told = drift.told()
        assert told["again"]["release"]["wanted"] == wanted
        same = wanted in (ID, f"{__version__}-solver-")
        assert told["again"]["state"] == ("same" if same else "drift")
        expected = f"release 0.0.1-solver-99 instead of {wanted.rstrip('-')}"
        assert told["old"]["drift"] == [expected]
        assert told["torn"]["drift"][-1] == "2 files damaged: x is missing"
        assert told["bare"]["drift"] == ["no release is in use"]


def test_robots_are_held_against_the_majority(drift: Program) -> None:
    off = {"nftables.service": {"enabled": "disabled", "active": "inactive"}}
    other = {"/etc/nftables.conf": "b" * 64}
    robots = [
        *(one(name) for name in "abc"),
        one("kernel", kernel="6.12.34+rpt-rpi-v8"),
        one("file", files=other),
        one("gone", files={"/etc/nftables.conf": None}),
        one("unit", units=off),
        # Another profile may render its files otherwise; there, there is no majority.
        one("lab-1", "lab", files=other),
        one("lab-2", "lab"),
    ]
    assert drift(*robots)[0] == 1
    told = drift.told()
    assert {name for name, entry in told.items() if entry["state"] == "same"} == set("abc")
    found = {
        name: (odd["name"], odd["has"], odd["majority"], odd["among"])
        for name, entry in told.items()
        for odd in entry["differs"]
    }
    assert found == {
        "kernel": ("kernel", "6.12.34+rpt-rpi-v8", "6.12.25+rpt-rpi-v8", "all"),
        "file": ("/etc/nftables.conf", "b" * 12, "a" * 12, "solver"),
        "gone": ("/etc/nftables.conf", "-", "a" * 12, "solver"),
        "unit": ("nftables.service", "disabled", "enabled, active", "solver"),
        "lab-1": ("/etc/nftables.conf", "b" * 12, None, "lab"),
        "lab-2": ("/etc/nftables.conf", "a" * 12, None, "lab"),
    }
    assert all(entry["drift"] == [] for entry in told.values())


def test_notes_are_no_drift(drift: Program) -> None:
    apt = {"upgradable": 7, "security": 2, "lists_days": 3.0}
    code, said = drift(one("a", reboot=["asked for by libc6"], apt=apt))
    assert code == 0
    assert "a: restart: asked for by libc6" in said
    assert "a: 7 of Debian's packages have a newer version, 2 for security" in said


def test_a_silent_robot_is_named_and_counts_more_than_drift(drift: Program) -> None:
    code, said = drift(one("a"), one("b", packages={}), one("c", why="no route\n to host"))
    assert code == 3
    assert "c: did not answer: no route to host" in said
    states = {name: entry["state"] for name, entry in drift.told().items()}
    assert states == {"a": "same", "b": "drift", "c": "unreachable"}


def test_what_cannot_be_used_is_said_in_one_sentence(drift: Program) -> None:
    assert "there is no lock" in drift(one("a", "other"))[1]
    assert drift(one("a", machine="armv7l"))[0] == 1
    for code, said in (
        drift(schema="other/1"),
        drift({"name": "a"}),  # type: ignore[arg-type]
        drift.run(drift.folder / "absent.json"),
    ):
        assert code == 2
        assert len(said.splitlines()) == 1
    (drift.folder / "locks/solver.txt").unlink()
    code, said = drift(one("a"))
    assert code == 2
    assert "solver.txt" in said


def test_the_page_stands_by_itself_and_escapes(drift: Program) -> None:
    drift(one("<b>a"), one("x", why="<script>"), one("c", packages={"alpha": "<i>"}))
    page = (drift.folder / "drift.html").read_text()
    assert not re.findall(
        r"<(script|link (?!rel=\"icon\" href=\"data:,\")|img|iframe|b>a|i>)", page
    )
    assert not re.findall(r"""(?:src|href)=["'](?!data:)|https?:|url\(|@import""", page)
    assert "&lt;b&gt;a" in page
    assert re.findall(r'class="badge (\w+)"', page) == ["same", "unreachable", "drift"]
    assert "prefers-color-scheme: dark" in page
    assert 'name="viewport"' in page


@pytest.mark.slow
def test_the_playbook_names_who_did_not_answer(tmp_path: Path) -> None:
    """Three hosts, two of them folders of this machine, one that nobody answers for."""
    program("ssh")  # what does not reach the robot that does not answer
    machine = "delta" if platform.machine() == "x86_64" else "beta-two"
    wanted = {"alpha": "1.0", "qrobot": __version__, "delta": "4.0"}
    wanted |= {"gamma": "3.0"} if machine == "delta" else {"beta-two": "2.0"}
    robot(tmp_path / "good", ID, wanted)
    robot(tmp_path / "odd", ID, {**wanted, "alpha": "0.9"})
    (tmp_path / "lock.txt").write_text(LOCK)
    hosts = {
        "good": {**LOCAL, "qrobot_root": f"{tmp_path}/good"},
        "odd": {**LOCAL, "qrobot_root": f"{tmp_path}/odd"},
        "dead": DEAD,
        "wrong": {**LOCAL, "qrobot_profile": "huge"},
    }
    settings: dict[str, Any] = {"qrobot_lock": f"{tmp_path}/lock.txt"}
    settings["drift_apt_seconds"] = 0  # this machine's packages are another matter
    settings |= {"qrobot_fetched": f"{tmp_path}/fleet", "qrobot_wheelhouse": f"{tmp_path}/none"}
    for name in ("good", "odd", "dead"):
        hosts[name] = {**hosts[name], "qrobot_profile": "solver"}
    done = play(tmp_path, ANSIBLE / "drift.yml", hosts, **settings)
    document = json.loads((tmp_path / "fleet/drift.json").read_text())
    told = {entry["name"]: entry for entry in document["robots"]}
    states = {name: entry["state"] for name, entry in told.items()}
    expected = {"good": "same", "odd": "drift", "dead": "unreachable", "wrong": "unreachable"}
    assert states == expected, done.stdout
    assert told["odd"]["packages"]["other"] == {"alpha": {"has": "0.9", "lock": "1.0"}}
    assert "Connection refused" in told["dead"]["why"]
    assert "refused" in told["wrong"]["why"]
    assert done.returncode == 2
    assert "dead: did not answer" in done.stdout

    quiet = {"good": hosts["good"]}
    done = play(tmp_path, ANSIBLE / "drift.yml", quiet, **settings)
    assert done.returncode == 0, done.stdout + done.stderr
