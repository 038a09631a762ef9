"""What is there: the releases under one root, read only."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path
from typing import Any

from .files import ReleaseError, compare, read

MB = 1_000_000
ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,79}")
NAMED = 20  # differences that are named one by one


class State:
    """The releases under one root, such as ``/opt/qrobot``, as they are.

    Parameters
    ----------
    root
        Folder that holds ``releases``, ``wheels``, ``current`` and ``history.json``.
    """

    def __init__(self, root: Path | str) -> None:
        self.root = Path(root)
        self.folder = self.root / "releases"
        self.current = self.root / "current"

    def status(self, verify: bool = False) -> dict[str, Any]:
        """State of the root.

        Parameters
        ----------
        verify
            Also compare each complete release with its manifest.

        Returns
        -------
        dict
            ``current``, ``previous`` (names or None), ``releases`` (newest first, each with ``id``,
            ``base``, ``complete``, ``size_mb``, ``installed_at``, ``note`` and, if verified,
            ``damaged``) and ``free_mb``.
        """
        releases = []
        for name in reversed(self._by_age()):
            manifest, record = self._manifest(name), self._record(name)
            entry = {
                "id": name,
                "base": self.base(name),
                "complete": manifest is not None,
                "size_mb": round(manifest["bytes"] / MB) if manifest else None,
                "installed_at": record.get("installed_at"),
                "note": record.get("note", {}),
            }
            if verify:
                entry["damaged"] = manifest is not None and self.verify(name)["count"] > 0
            releases.append(entry)
        past = self._earlier()
        return {
            "current": self.current_id(),
            "previous": past[0] if past else None,
            "releases": releases,
            "free_mb": self._free() // MB,
        }

    def current_id(self) -> str | None:
        """Name of the release in use; None without one, or when the link leads nowhere."""
        name = self._named()
        return name if name and (self.folder / name).is_dir() else None

    def base(self, name: str) -> str:
        """ID that a release was installed for: its name without the suffix of a second build."""
        return str(self._record(name).get("id", name))

    def uncompiled(self, name: str) -> str:
        """Why the searches of a release were not compiled, empty when they were, or need not be."""
        return str(self._record(name).get("uncompiled", ""))

    def complete_id_for(self, wanted: str, verify: bool = False) -> str | None:
        """Name of a complete release for an ID: the one in use, or else the latest.

        Parameters
        ----------
        wanted
            The ID, as it was given to `install`.
        verify
            Pass over those that are damaged.
        """
        found = [
            n for n in reversed(self._by_age()) if self.base(n) == wanted and self._complete(n)
        ]
        found.sort(key=lambda name: name != self.current_id())
        return next((n for n in found if not verify or not self.verify(n)["count"]), None)

    def verify(self, name: str) -> dict[str, Any]:
        """Compare a release with its manifest.

        Returns
        -------
        dict
            ``count`` of the differences and ``differences``, the first 20 of them.

        Raises
        ------
        ReleaseError
            When there is no release of that name.
        """
        manifest = self._manifest(self._existing(name))
        if manifest is None:
            return {"count": 1, "differences": ["manifest.json is missing: it is unfinished"]}
        found = list(compare(self.folder / name, manifest))
        return {"count": len(found), "differences": found[:NAMED]}

    # How

    def _log(self) -> list[dict[str, str]]:
        """Switches that took place, oldest first; the last one names the current release."""
        now = self._named()
        if now is None:
            return []
        log = [e for e in read(self.root / "history.json", list) or [] if isinstance(e, dict)]
        at = max((i for i, entry in enumerate(log) if entry.get("id") == now), default=None)
        return [*log, {"id": now, "how": "by hand"}] if at is None else log[: at + 1]

    def _earlier(self) -> list[str]:
        """Releases to go back to, the latest first: complete, and not the current one again."""
        now = self.current_id()
        if now is None:
            return []
        past: list[str] = []
        for entry in self._log():
            if entry.get("how") == "rollback" and entry["id"] in past:
                while past[-1] != entry["id"]:
                    past.pop()
            elif not past or past[-1] != entry["id"]:
                past.append(entry["id"])
        found: list[str] = []
        for name in reversed(past[:-1]):
            # The same ID as the current one is the damaged build that it replaced.
            if name not in found and self.base(name) != self.base(now) and self._complete(name):
                found.append(name)
        return found

    def _by_age(self) -> list[str]:
        """Releases, oldest first: by their last switch; those that wait for theirs are newest."""
        last = {entry["id"]: at for at, entry in enumerate(self._log())}
        return sorted(self._names(), key=lambda n: (last.get(n, len(last)), self._serial(n), n))

    def _names(self) -> list[str]:
        if not self.folder.is_dir():
            return []
        return [p.name for p in self.folder.iterdir() if ID.fullmatch(p.name) and p.is_dir()]

    def _named(self) -> str | None:
        """Release that the link names, whether it is there or not."""
        try:
            folder, name = os.path.split(os.readlink(self.current))
        except OSError:
            return None
        return name if folder == "releases" and ID.fullmatch(name) else None

    def _manifest(self, name: str) -> dict[str, Any] | None:
        manifest: dict[str, Any] | None = read(self.folder / name / "manifest.json", dict)
        return manifest if manifest and {"bytes", "files", "links"} <= set(manifest) else None

    def _complete(self, name: str) -> bool:
        return self._manifest(name) is not None

    def _record(self, name: str) -> dict[str, Any]:
        return read(self.folder / name / "release.json", dict) or {}

    def _serial(self, name: str) -> int:
        return int(self._record(name).get("serial", 0))

    def _replaced(self, name: str) -> bool:
        """Whether the release in use is a later build of the same one."""
        now = self.current_id()
        same = now is not None and self.base(now) == self.base(name)
        return same and self._serial(name) < self._serial(str(now))

    def _check_id(self, name: str) -> None:
        if not ID.fullmatch(name):
            raise ReleaseError(
                f"{name!r} is not an ID of a release: letters, digits and . _ + - only, up to 80", 2
            )

    def _existing(self, name: str) -> str:
        self._check_id(name)
        if name not in self._names():
            have = ", ".join(reversed(self._by_age())) or "none"
            raise ReleaseError(f"there is no release {name} under {self.root} (there: {have})", 2)
        return name

    def _free(self) -> int:
        place = Path(os.path.abspath(self.root))
        while not place.is_dir():
            place = place.parent
        return shutil.disk_usage(place).free
