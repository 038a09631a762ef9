#!/usr/bin/python
"""What provisioning must know of a machine, in one short visit."""

from __future__ import annotations

DOCUMENTATION = r"""
module: qrobot_facts
short_description: What provisioning must know of a machine, in one short visit
description:
  - Reads the machine, its system and its state; changes nothing, also outside check mode.
  - Ansible's own facts take several seconds on a Raspberry Pi; this takes one.
options:
  folder:
    description: Where releases will lie; the free room is told of its file system.
    type: path
    default: /opt
  firmware:
    description: Folders that may be the boot partition, the first with a config.txt counts.
    type: list
    elements: path
    default: [/boot/firmware, /boot]
author: The qRobot authors
"""

EXAMPLES = r"""
- name: Look at the machine
  qrobot_facts:
  register: machine
"""

RETURN = r"""
machine:
  description: C(arch), C(model), C(os), C(release), C(codename), C(python), C(kernel),
    C(memory_mb), C(free_mb), C(time) (seconds since 1970), C(firmware), C(systemd),
    C(dpkg_broken), C(apt_lists), C(swap_managed), C(swap_file), C(uid).
  returned: always
  type: dict
"""

import os
import platform
import shutil
import time
from pathlib import Path

from ansible.module_utils.basic import AnsibleModule

# Raspberry Pi OS trixie and the package zram-tools have compressed swap of their own.
SWAP_MANAGED = (
    "/usr/lib/systemd/system-generators/rpi-swap-generator",
    "/usr/lib/systemd/system/zramswap.service",
)


def _text(path):
    try:
        return Path(path).read_bytes().decode(errors="replace").rstrip("\0\n")
    except OSError:
        return ""


def _os_release():
    pairs = (line.partition("=") for line in _text("/etc/os-release").splitlines())
    return {name: value.strip('"') for name, _, value in pairs}


def _memory_mb():
    for line in _text("/proc/meminfo").splitlines():
        if line.startswith("MemTotal:"):
            return int(line.split()[1]) // 1024
    return 0


def _free_mb(folder):
    path = Path(folder)
    while not path.exists():
        path = path.parent
    return shutil.disk_usage(path).free // 1024**2


def _dpkg_broken():
    """Return whether dpkg was interrupted: what it had begun lies in ``updates``, or it says so."""
    updates = Path("/var/lib/dpkg/updates")
    if updates.is_dir() and any(updates.iterdir()):
        return True
    states = {
        "half-installed",
        "unpacked",
        "half-configured",
        "triggers-awaited",
        "triggers-pending",
    }
    for line in _text("/var/lib/dpkg/status").splitlines():
        if line.startswith("Status: ") and line.split()[-1] in states:
            return True
    return False


def main():
    module = AnsibleModule(
        argument_spec={
            "folder": {"type": "path", "default": "/opt"},
            "firmware": {
                "type": "list",
                "elements": "path",
                "default": ["/boot/firmware", "/boot"],
            },
        },
        supports_check_mode=True,
    )
    release = _os_release()
    firmware = next(
        (path for path in module.params["firmware"] if Path(path, "config.txt").is_file()), None
    )
    module.exit_json(
        changed=False,
        machine={
            "arch": platform.machine(),
            "model": _text("/proc/device-tree/model") or None,
            "os": release.get("ID", "unknown"),
            "release": release.get("VERSION_ID", ""),
            "codename": release.get("VERSION_CODENAME", ""),
            "python": ".".join(platform.python_version_tuple()[:2]),
            "kernel": platform.release(),
            "memory_mb": _memory_mb(),
            "free_mb": _free_mb(module.params["folder"]),
            "time": int(time.time()),
            "firmware": firmware,
            "systemd": Path("/run/systemd/system").is_dir(),
            "dpkg_broken": _dpkg_broken(),
            "apt_lists": any(Path("/var/lib/apt/lists").glob("*_Packages*")),
            "swap_managed": any(map(os.path.exists, SWAP_MANAGED)),
            "swap_file": os.path.exists("/usr/lib/systemd/system/dphys-swapfile.service"),
            "uid": os.geteuid(),
        },
    )


if __name__ == "__main__":
    main()
