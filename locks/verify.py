"""Check the locks.

Without arguments: offline and at once. No address in any lock, every pin hashed, one version of a
package in all locks, and every requirement met by its lock: those of pyproject.toml, and those of
the packages that are installed here.

With ``--install UV``: also install every profile for every platform into a scratch folder, as a
robot of that kind would (uv cross-installs; nothing is run), and print the sizes as a table.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.tags import compatible_tags, cpython_tags
from packaging.utils import canonicalize_name, parse_wheel_filename

LOCKS = Path(__file__).resolve().parent
PROFILES = {
    "base": [],
    "solver": ["solver"],
    "edge": ["edge"],
    "full": ["full"],
    "dev": ["solver", "dev", "docs", "provision"],
}
PYTHONS = ("3.11", "3.13")
MACHINES = ("aarch64", "x86_64")
GLIBC = "manylinux_2_28"
PIN = re.compile(r"^(?P<requirement>[A-Za-z0-9][^#\\]*==[^#\\]*?)\s*(?P<more>\\?)$")

Pins = dict[str, Requirement]


def environment(python: str, machine: str) -> dict[str, str]:
    """Marker values of a Linux robot."""
    return {
        "python_version": python,
        "python_full_version": f"{python}.2",
        "platform_machine": machine,
        "sys_platform": "linux",
        "os_name": "posix",
        "platform_system": "Linux",
        "implementation_name": "cpython",
        "platform_python_implementation": "CPython",
    }


def applies(requirement: Requirement, env: dict[str, str]) -> bool:
    return requirement.marker is None or requirement.marker.evaluate(env)


def read_lock(path: Path, env: dict[str, str]) -> Pins:
    """Pins of one lock that hold in one environment, by canonical name."""
    pins: Pins = {}
    for line in path.read_text().splitlines():
        if match := PIN.match(line):
            requirement = Requirement(match["requirement"])
            if applies(requirement, env):
                pins[canonicalize_name(requirement.name)] = requirement
    return pins


def version(pin: Requirement) -> str:
    return next(iter(pin.specifier)).version


def wanted(project: dict, extras: list[str], env: dict[str, str]) -> Iterator[Requirement]:
    """What pyproject.toml asks for with these extras, its references to itself followed."""
    texts = list(project["dependencies"])
    for extra in extras:
        texts += project["optional-dependencies"][extra]
    for requirement in map(Requirement, texts):
        if requirement.name == project["name"]:
            yield from wanted({**project, "dependencies": []}, sorted(requirement.extras), env)
        elif applies(requirement, env):
            yield requirement


def check_text(path: Path) -> Iterator[str]:
    lines = path.read_text().splitlines()
    for number, line in enumerate(lines, 1):
        if re.search(":/{2}", line):
            yield f"{path.name}:{number}: an address"
        elif (match := PIN.match(line)) and "--hash=" not in "".join(lines[number : number + 1]):
            yield f"{path.name}:{number}: {match['requirement']} has no hash"


def needed_by(pin: Requirement, env: dict[str, str]) -> Iterator[Requirement]:
    """What a pinned package itself asks for; nothing when this very version is not installed."""
    try:
        found = metadata.distribution(pin.name)
    except metadata.PackageNotFoundError:
        return
    if found.version == version(pin):
        for requirement in map(Requirement, found.requires or ()):
            extras = ["", *pin.extras]
            if requirement.marker is None or any(
                requirement.marker.evaluate(env | {"extra": extra}) for extra in extras
            ):
                yield requirement


def check_needs(stem: str, pins: Pins, env: dict[str, str]) -> Iterator[str]:
    """A package that was taken out of a lock by hand, though another needs it."""
    for pin in pins.values():
        for requirement in needed_by(pin, env):
            found = pins.get(canonicalize_name(requirement.name))
            if found is None or not requirement.specifier.contains(version(found), True):
                yield f'{stem}.txt lacks "{requirement}", which {pin.name} needs: run `make lock`'


def check() -> list[str]:
    """Every fault of the locks as one line each."""
    paths = sorted(LOCKS.glob("*.txt"))
    faults = [fault for path in paths for fault in check_text(path)]
    project = tomllib.loads((LOCKS.parent / "pyproject.toml").read_text())["project"]
    for python in PYTHONS:
        for machine in MACHINES:
            env = environment(python, machine)
            locks = {path.stem: read_lock(path, env) for path in paths}
            first: dict[str, tuple[str, str]] = {}
            for stem, pins in locks.items():
                faults += check_needs(stem, pins, env)
                for name, pin in pins.items():
                    where, known = first.setdefault(name, (stem, version(pin)))
                    if known != version(pin):
                        faults.append(
                            f"{name}: {known} in {where}.txt, {version(pin)} in {stem}.txt"
                        )
            for profile, extras in PROFILES.items():
                pins = locks.get(profile, {})
                for requirement in wanted(project, extras, env):
                    found = pins.get(canonicalize_name(requirement.name))
                    if found is None or version(found) not in requirement.specifier:
                        faults.append(
                            f'{profile}.txt does not meet "{requirement}"'
                            f" on Python {python}, {machine}: run `make lock`"
                        )
    return sorted(set(faults))


def download_size(uv: str, lock: Path, python: str, machine: str, scratch: Path) -> int:
    """Bytes of the wheels (or sdists) that an installer would take."""
    output = scratch / "pylock.toml"
    output.unlink(missing_ok=True)
    options = ["--format", "pylock.toml", "--no-deps", "--only-binary", ":all:"]
    options += ["--no-binary", "docplex", "--no-binary", "fastdtw", "--output-file"]
    run_uv(uv, "compile", python, machine, [*options, str(output), str(lock)])
    py = tuple(map(int, python.split(".")))
    platforms = [f"manylinux_2_{minor}_{machine}" for minor in range(28, 4, -1)]
    platforms += [f"manylinux{era}_{machine}" for era in ("2014", "2010", "1")]
    tags = [*cpython_tags(py, platforms=platforms)]
    tags += compatible_tags(py, f"cp{py[0]}{py[1]}", platforms)
    rank = {tag: place for place, tag in enumerate(tags)}
    total = 0
    for package in tomllib.loads(output.read_text())["packages"]:
        fits = [
            (min(rank[tag] for tag in wheel_tags & rank.keys()), wheel["size"])
            for wheel in package.get("wheels", [])
            if (wheel_tags := parse_wheel_filename(wheel["url"].rsplit("/", 1)[1])[3]) & rank.keys()
        ]
        total += min(fits)[1] if fits else package["sdist"]["size"]
    return total


def installed_size(uv: str, lock: Path, python: str, machine: str, scratch: Path) -> int:
    """Bytes on disk after a hash-checked install into an empty folder."""
    with tempfile.TemporaryDirectory(dir=scratch) as target:
        options = ["--require-hashes", "--link-mode", "hardlink", "--target"]
        run_uv(uv, "install", python, machine, [*options, target, "--requirement", str(lock)])
        return sum(
            os.lstat(os.path.join(folder, name)).st_size
            for folder, _, names in os.walk(target)
            for name in names
        )


def run_uv(uv: str, verb: str, python: str, machine: str, options: list[str]) -> None:
    platform = ["--python-version", python, "--python-platform", f"{machine}-{GLIBC}"]
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
    subprocess.run([uv, "pip", verb, "--quiet", *platform, *options], check=True, env=clean)


def install(uv: str) -> None:
    """Print the table of sizes; an install that fails ends the program."""
    print("| profile | Python | machine | packages | download MB | installed MB |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        for profile in PROFILES:
            lock = LOCKS / f"{profile}.txt"
            for machine in MACHINES:
                for python in PYTHONS:
                    count = len(read_lock(lock, environment(python, machine)))
                    sizes = [
                        measure(uv, lock, python, machine, scratch) / 1e6
                        for measure in (download_size, installed_size)
                    ]
                    print(
                        f"| {profile} | {python} | {machine} | {count} |"
                        f" {sizes[0]:.0f} | {sizes[1]:.0f} |",
                        flush=True,
                    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--install", metavar="UV", help="also install every profile with this uv")
    arguments = parser.parse_args()
    faults = check()
    print(*faults, sep="\n", end="\n" if faults else "")
    if faults:
        return 1
    if arguments.install:
        install(arguments.install)
    return 0


if __name__ == "__main__":
    sys.exit(main())
