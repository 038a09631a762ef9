"""Check the locks: ``python -m locks.verify``.

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
from collections.abc import Iterable, Iterator
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.tags import compatible_tags, cpython_tags
from packaging.utils import canonicalize_name, parse_wheel_filename

from locks import LOCKS, MACHINES, PIN, PROFILES, PYTHONS, Pin, environment, pins

GLIBC = "manylinux_2_28"

Pins = dict[str, Pin]


def applies(requirement: Requirement, env: dict[str, str]) -> bool:
    return requirement.marker is None or requirement.marker.evaluate(env)


def read_lock(path: Path, machine: str, python: str) -> Pins:
    """Pins of one lock that hold on one machine, by canonical name."""
    return {pin.name: pin for pin in pins(path.read_text(), machine, python)}


def wanted(project: dict, extras: Iterable[str], env: dict[str, str]) -> Iterator[Requirement]:
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
            yield f"{path.name}:{number}: {match['requirement'].strip()} has no hash"


def needed_by(pin: Pin, env: dict[str, str]) -> Iterator[Requirement]:
    """What a pinned package itself asks for; nothing when this very version is not installed."""
    try:
        found = metadata.distribution(pin.name)
    except metadata.PackageNotFoundError:
        return
    if found.version == pin.version:
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
            if found is None or not requirement.specifier.contains(found.version, True):
                yield f'{stem}.txt lacks "{requirement}", which {pin.name} needs: run `make lock`'


def check() -> list[str]:
    """Every fault of the locks as one line each."""
    paths = sorted(LOCKS.glob("*.txt"))
    faults = [fault for path in paths for fault in check_text(path)]
    project = tomllib.loads((LOCKS.parent / "pyproject.toml").read_text())["project"]
    for python in PYTHONS:
        for machine in MACHINES.values():
            env = environment(machine, python)
            locks = {path.stem: read_lock(path, machine, python) for path in paths}
            first: dict[str, tuple[str, str]] = {}
            for stem, held in locks.items():
                faults += check_needs(stem, held, env)
                for name, pin in held.items():
                    where, known = first.setdefault(name, (stem, pin.version))
                    if known != pin.version:
                        faults.append(
                            f"{name}: {known} in {where}.txt, {pin.version} in {stem}.txt"
                        )
            for profile, extras in PROFILES.items():
                held = locks.get(profile, {})
                for requirement in wanted(project, extras, env):
                    found = held.get(canonicalize_name(requirement.name))
                    if found is None or found.version not in requirement.specifier:
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
            for machine in MACHINES.values():
                for python in PYTHONS:
                    count = len(read_lock(lock, machine, python))
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
