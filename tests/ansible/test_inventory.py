"""The module qrobot_inventory: what a robot is found to have."""

from __future__ import annotations

import hashlib
import json
import platform
import re
from pathlib import Path
from typing import Any

from fleet_house import ANSIBLE, LOCAL, play, robot

OWNED = {"files": ["/etc/nftables.conf", "/etc/docker/daemon.json"], "units": ["cron.service"]}


def test_the_module_tells_what_is_on_the_disk(tmp_path: Path) -> None:
    system, root = tmp_path / "system", tmp_path / "opt"
    kernel = platform.release()
    # The same flavour, newer, by a number that is smaller as text; and another flavour.
    newer = re.sub(r"\d+", lambda found: str(int(found[0]) + 10**6), kernel, count=1)
    assert newer != kernel
    files = {
        "etc/os-release": 'ID=debian\nVERSION_CODENAME="trixie"\n',
        "etc/nftables.conf": "table\n",
        "etc/qrobot/provision.json": '{"profile": "solver"}',
        "boot/firmware/config.txt": "arm_64bit=1\n",
        "boot/firmware/cmdline.txt": "console=tty1 root=PARTUUID=1234-02 quiet\n",
        "run/reboot-required": "",
        "run/reboot-required.pkgs": "libc6\nlibc6\n",
        f"lib/modules/{kernel}/modules.dep": "",
        f"lib/modules/{newer}/modules.dep": "",
        "lib/modules/9999999.0-otherflavour/modules.dep": "",
    }
    for name, content in files.items():
        (system / name).parent.mkdir(parents=True, exist_ok=True)
        (system / name).write_text(content)
    made = robot(root, "1-solver-a", {"Foo_Bar": "1.0", "zope.x": "2.0"})
    (made.folder / "1-solver-a/lib/python3.11/site-packages/Foo_Bar-1.1.dist-info").mkdir()
    second = made.folder / "1-solver-a/lib/python3.11/site-packages/Foo_Bar-1.1.dist-info/METADATA"
    second.write_text("Name: foo-bar\nVersion: 1.1\n")
    next(made.folder.glob("*/lib/*/*/zope*/METADATA")).write_text("Name: zope.x\nVersion: 2.00\n")
    before = sorted((path, path.lstat().st_mtime_ns) for path in tmp_path.rglob("*"))

    look = {
        "qrobot_inventory": {"root": str(root), "system": str(system), **OWNED},
        "register": "seen",
    }
    keep = {
        "ansible.builtin.copy": {
            "content": "{{ seen | to_json }}",
            "dest": f"{tmp_path}/seen.json",
        },
        "check_mode": False,
    }
    tasks = [{**look, "check_mode": True}, keep]
    (tmp_path / "play.yml").write_text(json.dumps([{"hosts": "all", "tasks": tasks}]))
    done = play(tmp_path, tmp_path / "play.yml", {"a": LOCAL})
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted((p, p.lstat().st_mtime_ns) for p, _ in before) == before, "it changed something"

    answer = json.loads((tmp_path / "seen.json").read_text())
    assert answer["changed"] is False
    seen = answer["inventory"]
    assert seen["packages"] == {"foo-bar": "1.0 and 1.1", "zope-x": "2.00"}
    assert seen["python"] == "3.11"
    assert seen["release"]["id"] == "1-solver-a"
    assert seen["release"]["damage"]["count"] == 1
    assert "zope" in seen["release"]["damage"]["differences"][0]
    assert seen["provision"] == {"profile": "solver"}
    assert seen["codename"] == "trixie"
    assert seen["reboot"] == [
        "asked for by libc6",
        f"kernel {newer} is installed, {kernel} runs",
    ]
    there = {name: value for name, value in seen["files"].items() if value}
    assert there == {
        "/etc/nftables.conf": hashlib.sha256(b"table\n").hexdigest(),
        "boot/config.txt": hashlib.sha256(b"arm_64bit=1\n").hexdigest(),
        # What every card has of its own is left out.
        "boot/cmdline.txt": hashlib.sha256(b"console=tty1 quiet").hexdigest(),
    }


def test_the_module_reads_a_machine_that_was_never_provisioned(tmp_path: Path) -> None:
    look = {"qrobot_inventory": {"root": f"{tmp_path}/no", "system": f"{tmp_path}/no", **OWNED}}
    tasks = [
        {**look, "register": "seen"},
        {
            "ansible.builtin.assert": {
                "that": ["not seen.inventory.release", "not seen.inventory.reboot"]
            }
        },
    ]
    (tmp_path / "play.yml").write_text(json.dumps([{"hosts": "all", "tasks": tasks}]))
    done = play(tmp_path, tmp_path / "play.yml", {"a": LOCAL})
    assert done.returncode == 0, done.stdout + done.stderr
    assert not (tmp_path / "no").exists()


def test_flavours_of_kernels() -> None:
    """The names are those of Raspberry Pi OS and Debian, bookworm and trixie."""
    source = (ANSIBLE / "plugins/modules/qrobot_inventory.py").read_text()
    start, end = source.index("def flavour"), source.index("def reasons_to_reboot")
    space: dict[str, Any] = {"re": re}
    exec(source[start:end], space)
    flavours = {
        "6.12.25+rpt-rpi-v8": "rpi-v8",
        "6.1.0-rpi7-rpi-v8": "rpi-v8",
        "6.12.25+rpt-rpi-2712": "rpi-2712",
        "6.1.0-28-arm64": "arm64",
        "6.1.0-28-cloud-arm64": "cloud-arm64",
        "6.12.48+deb13-arm64": "arm64",
    }
    assert {name: space["flavour"](name) for name in flavours} == flavours
