"""On the virtual Pi: what a FAT disk holds after each line that replaces its boot files.

Reads {"source", "image", "files": {name: [old, new]}} and writes {"runs": [[state, ...], ...]}, a
state being the sectors that changed since the one before. In one run the kernel writes when it
likes, in the other everything that it has in its buffers is forced out after every line.
"""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
import tempfile
import types
import zlib
from pathlib import Path
from typing import Any

SECTOR = 512


def changed(old: bytes, new: bytes) -> dict[int, str]:
    """Return the sectors that differ, by number, as base64."""
    found = {}
    for part in range(0, len(new), 1 << 16):
        if old[part : part + (1 << 16)] == new[part : part + (1 << 16)]:
            continue
        for at in range(part, part + (1 << 16), SECTOR):
            if old[at : at + SECTOR] != new[at : at + SECTOR]:
                found[at // SECTOR] = base64.b64encode(new[at : at + SECTOR]).decode()
    return found


def run(given: dict[str, Any], folder: Path, forced: bool) -> list[dict[str, Any]]:
    image, mount = folder / "image", folder / "mount"
    mount.mkdir(exist_ok=True)
    last = zlib.decompress(base64.b64decode(given["image"]))
    image.write_bytes(last)
    subprocess.run(["mount", "-o", "loop", image, mount], check=True)
    rows = [row.split() for row in Path("/proc/mounts").read_text().splitlines()]
    device = os.open(next(row[0] for row in rows if row[1] == str(mount)), os.O_RDONLY)
    states: list[dict[str, Any]] = []

    def look(line: int) -> None:
        nonlocal last
        if forced:
            os.fsync(device)
        now = image.read_bytes()
        sectors = changed(last, now)
        if sectors:
            states.append({"line": line, "sectors": sectors})
        last = now

    def trace(frame: types.FrameType, event: str, _: Any) -> Any:
        if frame.f_code.co_filename != "qrobot_boot":
            return None
        if event in ("line", "return"):
            look(frame.f_lineno)
        return trace

    basic = types.ModuleType("ansible.module_utils.basic")
    basic.AnsibleModule = None  # type: ignore[attr-defined]
    sys.modules["ansible.module_utils.basic"] = basic
    module: dict[str, Any] = {"__name__": "qrobot_boot"}
    exec(compile(given["source"], "qrobot_boot", "exec"), module)
    sys.settrace(trace)
    for name, (_, new) in given["files"].items():
        module["write"](mount / name, new)
    sys.settrace(None)
    subprocess.run(["umount", mount], check=True)
    look(0)
    os.close(device)
    return states


def main() -> None:
    given = json.load(sys.stdin)
    with tempfile.TemporaryDirectory(dir="/var/tmp") as folder:
        runs = [run(given, Path(folder), forced) for forced in (False, True)]
    json.dump({"runs": runs}, sys.stdout)


if __name__ == "__main__":
    main()
