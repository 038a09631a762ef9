"""Another version of qRobot's wheel, made of a real one: with a fault in it on purpose."""

from __future__ import annotations

import base64
import hashlib
import zipfile
from pathlib import Path


def another(wheel: Path, folder: Path, version: str, **edits: tuple[str, str]) -> Path:
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
        By module, ``__`` in place of ``/``: a text that is in it, and what replaces it.
    """
    old = wheel.name.split("-")[1]
    target = folder / wheel.name.replace(f"-{old}-", f"-{version}-")
    changes = {f"{name.replace('__', '/')}.py": pair for name, pair in edits.items()}
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
