"""Machines for the tests of the roles (where none can be had, a reason), collectors of wheels."""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from collector_house import House, python_with_pip
from machine import CACHE, PLAYBOOKS, RELEASE, Machine, Run, why_not

BOOT = Path(__file__).parent / "fixtures" / "boot" / "trixie"
PYTHON = {"trixie": "3.13", "bookworm": "3.11"}[RELEASE]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = [item for item in items if Path(__file__).parent in item.path.parents]
    needs = [item for item in here if "machine" in getattr(item, "fixturenames", ())]
    if needs and (reason := why_not()):
        for item in needs:
            item.add_marker(pytest.mark.skip(reason=reason))


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of qRobot, built once; every other wheel is collected too."""
    done = subprocess.run(
        [sys.executable, PLAYBOOKS / "controller/wheelhouse.py", "--profile", "solver",
         "--python", PYTHON, "--machine", platform.machine(),
         "--dest", CACHE / "wheelhouse", "--json"],
        stdout=subprocess.PIPE, text=True, check=True,
    )  # fmt: skip
    files = json.loads(done.stdout)["files"]
    name = next(file["name"] for file in files if file["name"].startswith("qrobot-"))
    return Path(shutil.copy(CACHE / "wheelhouse/files" / name, tmp_path_factory.mktemp("wheel")))


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    """A bare machine of this file's own."""
    boot = {path.name: path.read_bytes() for path in BOOT.iterdir()}
    machine = Machine(tmp_path_factory.mktemp("machine"), boot)
    try:
        machine.start()
        yield machine
    finally:
        machine.stop()


@pytest.fixture(scope="module")
def provision(machine: Machine, wheel: Path) -> Callable[..., Run]:
    """Run provision.yml; the same wheel gives the same release."""

    def call(*options: str, **variables: object) -> Run:
        given = {"qrobot_wheel": str(wheel)} | variables
        return machine.playbook("provision.yml", *options, **given)

    return call


@pytest.fixture(scope="session")
def python(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A Python with pip that sees what this one sees."""
    return python_with_pip(tmp_path_factory)


@pytest.fixture
def house(tmp_path: Path, python: str) -> House:
    """A lock, an index in a folder, and the program that collects from it."""
    return House(tmp_path, python)
