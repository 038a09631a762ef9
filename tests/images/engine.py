"""The Docker engine, as the tests of the images call it."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ARCH = {"x86_64": "amd64", "aarch64": "arm64"}.get(platform.machine(), platform.machine())
RELEASE = os.environ.get("QROBOT_IMAGES", "")
"""The release whose images `make test-images` has built."""
BUILT = os.environ.get("QROBOT_TARGETS", "solver edge lab").split()
"""Which of them."""


def docker(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run docker to its end."""
    return subprocess.run(["docker", *arguments], capture_output=True, text=True, check=False)


def why_not() -> str:
    """Say why the images cannot be tried here, "" when they can."""
    if not RELEASE:
        return "wants images and a Docker engine: make test-images"
    if shutil.which("docker") is None or docker("info").returncode:
        return "no Docker engine answers"
    return ""
