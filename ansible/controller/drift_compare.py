"""In what robots differ from their lock, from the release of this checkout, and from each other."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common import read_json
from packaging.version import InvalidVersion, Version

from locks import MACHINES, ROBOTS, lock_of, pins
from qrobot import __version__
from qrobot._text import count
from qrobot.errors import InputError
from qrobot.health.reports import Column

ABSENT = "-"
PINNED = re.compile(r"^([\w.-]+)==([^\s;]+)", re.MULTILINE)


@dataclass
class Checkout:
    """What this checkout would install.

    Parameters
    ----------
    locks
        Folder of the locks.
    wheelhouse
        Folder of what wheelhouse.py collected; it may be missing.
    """

    locks: Path
    wheelhouse: Path
    known: dict[tuple[str, str, str], dict[str, str]] = field(default_factory=dict)

    def packages(self, lock: str, machine: str, python: str) -> dict[str, str]:
        """Return name to version of what a lock pins there, and qRobot itself."""
        key = (lock, machine, python)
        if key not in self.known:
            path = self.locks / lock  # an absolute path stays what it is
            try:
                text = path.read_text()
                found = {pin.name: pin.version for pin in pins(text, machine, python)}
            except OSError as error:
                why = f"not readable ({error.strerror})"
                raise InputError(why, source=str(path), field="lock") from None
            except ValueError as error:
                why = f"is not a lock ({str(error).splitlines()[0]})"
                raise InputError(why, source=str(path), advice="run `make lock`") from None
            if not found:
                raise InputError("it pins nothing", source=str(path), advice="run `make lock`")
            self.known[key] = {**found, "qrobot": __version__}
        return self.known[key]

    def release(self, profile: str, machine: str, python: str, lock: dict[str, str]) -> str:
        """Return the release's ID, or its beginning when no collection of wheels tells the end.

        A collection that was made for another version or another lock tells nothing.
        """
        made = read_json(self.wheelhouse / f"{profile}-{python}-{machine}.json")
        start = f"{__version__}-{profile}-"
        if not isinstance(made, dict) or not str(made.get("id")).startswith(start):
            return start
        collected = dict(PINNED.findall(str(made.get("requirements"))))
        return str(made["id"]) if not any(_packages(collected, lock).values()) else start


def compare(robots: list[dict[str, Any]], checkout: Checkout) -> dict[str, Any]:
    """Return the document qrobot.drift/1 without its time."""
    entries = [_robot(robot, checkout) for robot in robots]
    columns = _columns({r["name"]: r for r in robots if r["inventory"]})
    for entry in entries:
        for group, column in columns:
            value = column.values.get(entry["name"])
            if value is not None and value != column.majority:
                odd = {"kind": column.kind, "name": column.name, "among": group, "has": value}
                entry["differs"].append({**odd, "majority": column.majority})
        if entry["state"] == "same" and (entry["drift"] or entry["differs"]):
            entry["state"] = "drift"
    states = [entry["state"] for entry in entries]
    return {
        "schema": "qrobot.drift/1",
        "version": __version__,
        "totals": {s: states.count(s) for s in ("same", "drift", "unreachable")},
        "robots": entries,
        "differences": [
            {
                "kind": column.kind,
                "name": column.name,
                "among": group,
                "majority": column.majority,
                "different": column.different,
            }
            for group, column in columns
        ],
    }


def _robot(robot: dict[str, Any], checkout: Checkout) -> dict[str, Any]:
    """Hold one robot against its lock and its release."""
    profile, seen = robot["settings"].get("profile", ""), robot["inventory"]
    entry: dict[str, Any] = {
        "name": robot["name"],
        "profile": profile,
        "state": "same" if seen else "unreachable",
        "why": " ".join(str(robot["why"]).removeprefix("Task failed: ").split()),
        "release": {"in_use": None, "wanted": None},
        "packages": {"missing": {}, "extra": {}, "other": {}},
        "drift": [],
        "differs": [],
        "notes": [],
    }
    if not seen:
        return entry
    if profile not in ROBOTS or seen["machine"] not in MACHINES.values():
        known = f"profile {profile or '-'} on {seen['machine']}"
        entry["drift"] = [f"there is no lock for {known}"]
        return entry
    lock = checkout.packages(
        robot["settings"].get("lock") or lock_of(profile), seen["machine"], seen["python"]
    )
    wanted = checkout.release(profile, seen["machine"], seen["python"], lock)
    entry["release"]["wanted"] = wanted
    entry["notes"] = _notes(seen)
    release = seen["release"]
    if release is None:
        entry["drift"] = ["no release is in use"]
        return entry
    entry["release"] |= {"in_use": release["id"], "previous": release["previous"]}
    entry["packages"] = _packages(seen["packages"], lock)
    drift = entry["drift"]
    base = str(release["base"])
    if not (base.startswith(wanted) if wanted.endswith("-") else base == wanted):
        drift.append(f"release {base} instead of {wanted.removesuffix('-')}")
    for kind, found in entry["packages"].items():
        if found:
            first = ", ".join(list(found)[:3]) + (", ..." if len(found) > 3 else "")
            word = {"other": "in another version"}.get(kind, kind)
            drift.append(f"{count(len(found), 'package')} {word} ({first})")
    damage = release["damage"]
    if damage["count"]:
        drift.append(f"{count(damage['count'], 'file')} damaged: {damage['differences'][0]}")
    drift += [f"{name} has failed" for name, u in seen["units"].items() if u["active"] == "failed"]
    return entry


def _packages(has: dict[str, str], lock: dict[str, str]) -> dict[str, dict[str, Any]]:
    return {
        "missing": {name: lock[name] for name in sorted(lock.keys() - has.keys())},
        "extra": {name: has[name] for name in sorted(has.keys() - lock.keys())},
        "other": {
            name: {"has": has[name], "lock": lock[name]}
            for name in sorted(lock.keys() & has.keys())
            if _version(has[name]) != _version(lock[name])
        },
    }


def _version(text: str) -> Version | str:
    """Return a version that 1.0 and 1.0.0 share; a text that is none is itself."""
    try:
        return Version(text)
    except InvalidVersion:
        return text


def _notes(seen: dict[str, Any]) -> list[str]:
    """Say what asks for attention but does not count as drift."""
    notes = [f"restart: {reason}" for reason in seen["reboot"]]
    apt = seen["apt"]
    if apt and apt["upgradable"]:
        notes.append(
            f"{apt['upgradable']} of Debian's packages have a newer version, {apt['security']} for "
            f"security (lists {apt['lists_days']:g} days old)"
        )
    return notes


def _columns(robots: dict[str, dict[str, Any]]) -> list[tuple[str, Column]]:
    """Return what is not the same everywhere, each with the group that it was compared in.

    Systems are compared over the fleet; what is rendered or switched on, among robots of a profile.
    """
    seen = {name: robot["inventory"] for name, robot in robots.items()}
    found: list[tuple[str, Column]] = []
    for name in ("codename", "python", "kernel", "firmware"):
        values = {robot: str(facts[name] or ABSENT) for robot, facts in seen.items()}
        found.append(("all", Column("system", name, dict(values))))
    for profile in sorted({robot["settings"].get("profile", "") for robot in robots.values()}):
        group = {n: seen[n] for n, r in robots.items() if r["settings"].get("profile") == profile}
        for path in sorted({path for facts in group.values() for path in facts["files"]}):
            values = {n: (facts["files"].get(path) or ABSENT)[:12] for n, facts in group.items()}
            found.append((profile, Column("file", path, dict(values))))
        for unit in sorted({unit for facts in group.values() for unit in facts["units"]}):
            values = {n: _unit(facts["units"].get(unit)) for n, facts in group.items()}
            found.append((profile, Column("unit", unit, dict(values))))
    return [(group, column) for group, column in found if len(set(column.values.values())) > 1]


def _unit(state: dict[str, str] | None) -> str:
    """How a unit is switched; a service that runs now and then is not judged by its state now."""
    if state is None:
        return ABSENT
    if state["enabled"] == "enabled":
        return f"enabled, {state['active']}"
    return str(state["enabled"])
