"""The environment of a release, made by uv from the wheels on this machine."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

from .files import ReleaseError, write


class CompileError(ReleaseError):
    """The searches of a release were not compiled, and not because the disk is full."""


def last_error(output: str) -> str:
    """Return what uv says went wrong, in one line."""
    found = re.findall(r"^\s*(?:error|cause):\s*(.+)$", output, re.MULTILINE)
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    text = ": ".join(found) or (lines[-1] if lines else "uv gave no reason")
    return text.replace("Failed to download", "cannot use").rstrip(".")


def build(
    target: Path,
    scratch: Path,
    requirements: str,
    wheels: Path,
    uv: Path,
    python: str,
    held: tuple[int, ...] = (),
) -> None:
    """Make the environment of a release.

    Wheels are unpacked once, into a cache on the same file system, and linked from there; the
    cache goes afterwards, so that no two releases share a file.

    Parameters
    ----------
    target
        Folder of the release.
    scratch
        Folder for the cache.
    requirements, wheels, uv, python
        As for `Releases.install`.
    held
        Descriptors of locks that uv holds as long as it lives.

    Raises
    ------
    ReleaseError
        When uv cannot, with what it says.
    """
    always: list[Any] = ["--quiet", "--offline", "--no-config", "--no-python-downloads"]
    always += ["--cache-dir", scratch / "cache"]
    made = [uv, "venv", *always, "--no-project", "--python", python, target]
    _run(made, target.name, scratch, held)
    write(target / "requirements.txt", requirements)
    install = [uv, "pip", "install", *always, "--python", target / "bin" / "python"]
    install += ["--no-index", "--find-links", wheels, "--require-hashes", "--no-deps"]
    install += ["--no-build", "--compile-bytecode", "--link-mode", "hardlink"]
    install += ["--requirement", target / "requirements.txt"]
    _run(install, target.name, scratch, held)
    (target / ".lock").unlink(missing_ok=True)  # uv's own, writable for all


def compile_searches(
    target: Path, scratch: Path, older: Path | None, held: tuple[int, ...] = ()
) -> str:
    """Compile the searches of a release that has numba.

    The machine code lies beside the package: its users and services read it there, and it goes
    with the release.

    Parameters
    ----------
    target, scratch, held
        As for `build`.
    older
        A release whose machine code is taken over where the searches are the same.

    Returns
    -------
    str
        Why they were not compiled, empty when they were: its proof tells it, as it tells what
        else is wrong with a release.

    Raises
    ------
    ReleaseError
        When the disk is full.
    """
    if not any(target.glob("lib/python*/site-packages/numba-*.dist-info")):
        return ""
    command: list[Any] = [target / "bin" / "qrobot", "compile"]
    packages = list(older.glob("lib/python*/site-packages/qrobot")) if older else []
    if packages:
        command += ["--from", packages[0]]
    try:
        _run(command, target.name, scratch, held)
    except CompileError as error:
        return str(error)
    return ""


def _run(command: list[Any], release: str, scratch: Path, held: tuple[int, ...]) -> None:
    """Run uv, or a program of the release, with a clean environment."""
    place = {
        "PATH": "/usr/bin:/bin",
        "HOME": str(scratch),
        "TMPDIR": str(scratch),
        "LC_ALL": "C.UTF-8",
    }
    try:
        done = subprocess.run(
            [str(word) for word in command],
            env=place,
            cwd=scratch,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            pass_fds=held,
        )
    except OSError as error:
        raise ReleaseError(f"cannot run {command[0]}: {error.strerror}", 2) from None
    if done.returncode:
        reason = last_error(done.stderr or done.stdout)
        advice = "collect its wheels again"
        if "No space left" in reason:
            advice = "make room"
        elif command[1] == "compile":
            raise CompileError(reason)
        raise ReleaseError(f"the release {release} was not installed: {reason}: {advice}")
