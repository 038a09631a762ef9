#!/usr/bin/python
"""What a robot has, in one short visit: the facts that drift is told from."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_inventory
short_description: What a robot has, in one short visit
description:
  - Reads the release in use, its packages, the system, the files that the playbooks manage, and
    the state of their units; changes nothing, also outside check mode, and asks no network.
  - Packages are listed by their metadata; nothing is imported.
options:
  root:
    description: Folder of the releases.
    type: path
    default: /opt/qrobot
  system:
    description: Folder that stands for the file system's root.
    type: path
    default: /
  files:
    description: The files that the roles own.
    type: list
    elements: str
    required: true
  units:
    description: The units that the roles own.
    type: list
    elements: str
    required: true
  apt_seconds:
    description: How long apt may take to count what can be upgraded by its lists; 0 leaves it out.
    type: int
    default: 30
author: The qRobot authors
attributes:
  check_mode:
    support: full
"""

EXAMPLES = r"""
- name: Look at the robot
  qrobot_inventory:
    files: "{{ query('qrobot_owns', 'files', 'shared', 'stays') }}"
    units: "{{ query('qrobot_owns', 'units') }}"
  register: seen
"""

RETURN = r"""
inventory:
  description: C(release), C(provision), C(packages), C(python), C(machine), C(model), C(codename),
    C(kernel), C(firmware), C(files), C(units), C(reboot), C(apt). docs/fleet.md tells what each is.
  returned: always
  type: dict
"""

import hashlib
import platform
import re
import shutil
import subprocess
import time
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule
from ansible.module_utils.qrobot_release import Releases, read

BOOT = ("/boot/firmware", "/boot")
# Every card has its own identity there.
OWN = re.compile(rb"(?:root|resume|cloud-init\.\S+|ds)=")


def output_of(command, seconds):
    """Return what a program prints, or None when it is absent, fails or takes too long."""
    try:
        done = subprocess.run(
            command,
            env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=seconds,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def read_text(path):
    try:
        return path.read_bytes().decode(errors="replace").rstrip("\0\n")
    except OSError:
        return ""


def release_in_use(releases):
    """Name, origin and damage of the release in use, or None."""
    state = releases.status()
    for entry in state["releases"]:
        if entry["id"] == state["current"]:
            keys = ("id", "base", "installed_at", "note")
            found = {key: entry[key] for key in keys}
            return {**found, "previous": state["previous"], "damage": releases.verify(entry["id"])}
    return None


def packages(current):
    """Distributions in an environment: name in its one spelling to version, and its Python."""
    found, python = {}, None
    for folder in sorted(current.glob("lib/python3*/site-packages")):
        python = folder.parent.name.removeprefix("python")
        for path in sorted(folder.glob("*.dist-info/METADATA")):
            fields = {}
            with open(path, encoding="utf-8", errors="replace") as file:
                for line in file:
                    name, _, value = line.partition(":")
                    if not line.strip() or len(fields) == 2:
                        break  # the end of the head
                    if name.lower() in ("name", "version"):
                        fields[name.lower()] = value.strip()
            if len(fields) == 2:
                key = re.sub(r"[-_.]+", "-", fields["name"]).lower()
                # Two versions of one package are a fault that must not hide.
                found[key] = " and ".join(filter(None, (found.get(key), fields["version"])))
    return found, python


def managed_files(system, names):
    """Hash of every managed file, None where it is not there."""
    found = {}
    for name in names:
        try:
            content = (system / name[1:]).read_bytes()
        except OSError:
            found[name] = None
        else:
            found[name] = hashlib.sha256(content).hexdigest()
    for folder in BOOT:
        config = system / folder[1:] / "config.txt"
        if not config.is_file():
            continue
        for path in (config, config.with_name("cmdline.txt")):
            content = path.read_bytes() if path.is_file() else b""
            if path.name == "cmdline.txt":
                content = b" ".join(word for word in content.split() if not OWN.match(word))
            found[f"boot/{path.name}"] = hashlib.sha256(content).hexdigest()
        break
    return found


def flavour(kernel):
    """Which line of kernels one is of: ``rpi-v8`` of 6.12.25+rpt-rpi-v8 and 6.1.0-rpi7-rpi-v8."""
    parts = kernel.split("-")[1:]
    while parts and re.fullmatch(r"(rpi)?\d+", parts[0]) and len(parts) > 1:
        parts.pop(0)
    return "-".join(parts)


def newest_kernel(kernel, modules):
    """Return the newest installed kernel of the same flavour."""

    def age(name):
        return [int(number) for number in re.findall(r"\d+", name.removesuffix(flavour(name)))]

    there = [path.parent.name for path in modules.glob("*/modules.dep")]
    return max([kernel, *(name for name in there if flavour(name) == flavour(kernel))], key=age)


def reasons_to_reboot(system, kernel):
    """Sentences; none when the robot runs what is installed."""
    found = []
    run = system / "run"
    if (run / "reboot-required").exists():
        names = sorted(set(read_text(run / "reboot-required.pkgs").split()))
        found.append(f"asked for by {', '.join(names) or 'a package'}")
    newest = newest_kernel(kernel, system / "lib/modules")
    if newest != kernel:
        found.append(f"kernel {newest} is installed, {kernel} runs")
    return found


def units(names):
    """Enablement and state of the units of the playbooks that are there."""
    show = ["systemctl", "show", "--property=Id,LoadState,UnitFileState,ActiveState", *names]
    found = {}
    for block in (output_of(show, 20) or "").split("\n\n"):
        unit = dict(line.split("=", 1) for line in block.splitlines() if "=" in line)
        if unit.get("LoadState") not in (None, "not-found"):
            state = {"enabled": unit.get("UnitFileState"), "active": unit.get("ActiveState")}
            found[unit["Id"]] = state
    return found


def upgradable(system, seconds):
    """How many packages apt's lists know a newer version of, and the age of the lists."""
    lists = [path.stat().st_mtime for path in (system / "var/lib/apt/lists").glob("*_Packages*")]
    if not lists or not seconds:
        return None
    listed = output_of(["apt", "list", "--upgradable"], seconds)
    if listed is None:
        return None
    lines = [line for line in listed.splitlines() if "[upgradable from" in line]
    return {
        "upgradable": len(lines),
        "security": sum("-security" in line.split()[0] for line in lines),
        "lists_days": round((time.time() - max(lists)) / 86400, 1),
    }


def firmware():
    """Day and commit of the firmware that the board started with; None where nothing tells."""
    if shutil.which("vcgencmd") is None:
        return None
    lines = (output_of(["vcgencmd", "version"], 10) or "").splitlines()
    commit = re.search(r"^version (\w{8})", "\n".join(lines), re.MULTILINE)
    return f"{' '.join(lines[0].split())} {commit[1]}" if commit else None


def main():
    module = AnsibleModule(
        argument_spec={
            "root": {"type": "path", "default": "/opt/qrobot"},
            "system": {"type": "path", "default": "/"},
            "files": {"type": "list", "elements": "str", "required": True},
            "units": {"type": "list", "elements": "str", "required": True},
            "apt_seconds": {"type": "int", "default": 30},
        },
        supports_check_mode=True,
    )
    system, kernel = Path(module.params["system"]), platform.release()
    releases = Releases(module.params["root"], dry=True)
    lines = read_text(system / "etc/os-release").splitlines()
    os_release = dict(line.split("=", 1) for line in lines if "=" in line)
    try:
        release = release_in_use(releases)
        installed, python = packages(releases.current) if release else ({}, None)
        files = managed_files(system, module.params["files"])
    except OSError as error:
        module.fail_json(msg=f"{error.filename}: {error.strerror}")
    module.exit_json(
        changed=False,
        inventory={
            "release": release,
            "provision": read(system / "etc/qrobot/provision.json", dict),
            "packages": installed,
            "python": python or ".".join(platform.python_version_tuple()[:2]),
            "machine": platform.machine(),
            "model": read_text(system / "proc/device-tree/model") or None,
            "codename": os_release.get("VERSION_CODENAME", "").strip('"'),
            "kernel": kernel,
            "firmware": firmware(),
            "files": files,
            "units": units(module.params["units"]),
            "reboot": reasons_to_reboot(system, kernel),
            "apt": upgradable(system, module.params["apt_seconds"]),
        },
    )


if __name__ == "__main__":
    main()
