"""Images that `make test-images` has built, and a Docker engine; elsewhere a reason."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from images.engine import ARCH, BUILT, RELEASE, ROOT, docker, why_not

Run = Callable[..., "subprocess.CompletedProcess[str]"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = [item for item in items if Path(__file__).parent in item.path.parents]
    needs = [item for item in here if "image" in getattr(item, "fixturenames", ())]
    if needs and (reason := why_not()):
        for item in needs:
            item.add_marker(pytest.mark.skip(reason=reason))


@pytest.fixture(scope="session")
def image() -> Callable[[str], str]:
    """Return the engine's name of an image, loaded from where it was built."""

    def name(target: str) -> str:
        if target not in BUILT:
            pytest.skip(f"the image {target} was not built: make test-images IMAGES={target!r}")
        full = f"qrobot:{target}-{RELEASE}-{ARCH}"
        subprocess.run([ROOT / "docker/load.sh", full], check=True)
        return full

    return name


@pytest.fixture(scope="session")
def config(image: Callable[[str], str]) -> Callable[[str], dict[str, Any]]:
    """Return what an image is configured to."""

    def of(target: str) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(docker("image", "inspect", image(target)).stdout)[0]
        return found["Config"]

    return of


@pytest.fixture
def run(image: Callable[[str], str]) -> Run:
    """Run a container with the options of docker, to its end."""

    def call(target: str, *arguments: str, options: tuple[str, ...] = ()):
        return docker("run", "--rm", *options, image(target), *arguments)

    return call
