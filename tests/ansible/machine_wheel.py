"""Another version of qRobot's wheel, made of a real one: with a fault in it on purpose."""

from __future__ import annotations

import base64
import hashlib
import zipfile
from pathlib import Path

Edits = dict[str, tuple[str, str]]
"""By file of the wheel: a text that is in it, and what replaces it."""

WRONG_PLANS: Edits = {
    "qrobot/backends/classical/exact/partition.py": (
        "taken = int(np.argmin(best[k - 1][parts[run]] + trip_costs[k][rests[run]]))",
        "both = best[k - 1][parts[run]] + trip_costs[k][rests[run]]\n"
        "        taken = int(np.argmax(np.where(np.isfinite(both), both, -1.0)))",
    )
}
"""The exact solver takes the worst partition instead of the best one."""

NO_START: Edits = {
    "qrobot/cli/main.py": ("from __future__ import annotations", "import planted_fault")
}
"""The command line imports what does not exist."""

NO_MACHINE_CODE: Edits = {
    "qrobot/backends/classical/compilation.py": (
        'load("numba", "compiling the searches")',
        'raise RuntimeError("no such processor")',
    )
}
"""The searches do not compile; all else works."""


def another(wheel: Path, folder: Path, version: str, edits: Edits | None = None) -> Path:
    """Write a wheel of another version.

    Parameters
    ----------
    wheel
        A wheel of qRobot.
    folder
        Where the other one goes.
    version
        Its version.
    edits
        What is changed in it beside the version.
    """
    old = wheel.name.split("-")[1]
    target = folder / wheel.name.replace(f"-{old}-", f"-{version}-")
    changes = dict(edits or {})
    changes["qrobot/_version.py"] = (f'"{old}"', f'"{version}"')
    changes["METADATA"] = (f"\nVersion: {old}\n", f"\nVersion: {version}\n")
    record = ""
    with zipfile.ZipFile(wheel) as source, zipfile.ZipFile(target, "w") as copy:
        for entry in source.infolist():
            content = source.read(entry)
            name = entry.filename.replace(f"qrobot-{old}.", f"qrobot-{version}.")
            if name.endswith("/RECORD"):
                continue
            pair = changes.pop(name, None) or changes.pop(Path(name).name, None)
            if pair:
                assert pair[0].encode() in content, f"{name} no longer holds {pair[0]!r}"
                content = content.replace(pair[0].encode(), pair[1].encode())
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode()
            record += f"{name},sha256={digest.rstrip('=')},{len(content)}\n"
            copy.writestr(zipfile.ZipInfo(name), content)
        assert not changes, f"not in the wheel: {sorted(changes)}"
        info = f"qrobot-{version}.dist-info/RECORD"
        copy.writestr(zipfile.ZipInfo(info), record + f"{info},,\n")
    return target
