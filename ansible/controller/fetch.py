"""What is asked of pip and hatchling: wheels for another machine, and wheels of source archives.

pip asks whatever index it is configured for; no address is known here, and none is shown.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

from common import ROOT, say, sha256
from store import File, Store

from locks import LOCKS, Pin, pins
from qrobot.errors import BackendError, RemoteError

SOURCE_ONLY = frozenset({"docplex", "fastdtw"})  # as in locks/compile.sh; both pure Python
BATCH = 8  # wheels a call: what an interrupted run loses at most
BUILD_LOCK = LOCKS / "build.txt"
# 1980 is where the dates of zip files begin: the same source gives the same bytes.
SAME_BYTES = {"SOURCE_DATE_EPOCH": "315532800", "PYTHONHASHSEED": "0"}
SILENT = re.compile(
    r"connection broken|ConnectionError|ConnectTimeout|timed out|Could not fetch URL"
    r"|Name or service not known|ProxyError|HTTP error 5"
)
NONE_THERE = re.compile(r"No matching distribution|no file for")
OTHER_BYTES = re.compile(r"DO NOT MATCH THE HASHES")


def fetch(missing: list[Pin], store: Store, progress: Callable[[list[File]], None]) -> list[File]:
    """Bring the wheels of pins into the store.

    Raises
    ------
    RemoteError
        When some cannot be had; it names them. Those that came are kept.
    """
    files: list[File] = []
    failed: dict[str, str] = {}

    def take(some: list[Pin], ask: Callable[[list[Pin], Store], list[File] | str]) -> str:
        answer = ask(some, store)
        if isinstance(answer, str):
            return answer
        files.extend(answer)
        progress(files)
        return ""

    binary = [pin for pin in missing if pin.name not in SOURCE_ONLY]
    todo = [(binary[at : at + BATCH], _download) for at in range(0, len(binary), BATCH)]
    todo += [([pin], _build) for pin in missing if pin.name in SOURCE_ONLY]
    while todo:
        some, ask = todo.pop(0)
        fault = take(some, ask)
        if fault and SILENT.search(fault):
            for pin in [*some, *(pin for later, _ in todo for pin in later)]:
                failed[f"{pin.name}-{pin.version}"] = "no index answered"
            break
        if fault and len(some) > 1:  # one of them: which?
            todo[:0] = [([pin], ask) for pin in some]
        elif fault and OTHER_BYTES.search(fault):
            name = _refused_file(fault) or f"{some[0].name}-{some[0].version}"
            failed[name] = "the index serves other bytes than the lock allows"
        elif fault:
            none = f"the index has no file that the lock allows for {store.target}"
            why = none if NONE_THERE.search(fault) else f"pip failed, {_last_line(fault)}"
            failed[f"{some[0].name}-{some[0].version}"] = why
    if failed:
        raise RemoteError(_missing(failed, len(missing)))
    return files


def _missing(failed: dict[str, str], asked: int) -> str:
    reasons = sorted(set(failed.values()))
    parts = []
    for reason in reasons:
        names = [name for name, why in failed.items() if why == reason]
        shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
        parts.append(f"{reason} ({shown})")
    verb = "wheels is" if len(failed) == 1 else "wheels are"
    advice = "connect this machine, or point pip at an index or a folder that has them"
    return (
        f"{len(failed)} of {asked} {verb} missing: {'; '.join(parts)}: {advice}, and run it again"
    )


def _refused_file(fault: str) -> str | None:
    """Return the name of the file that had other bytes, without where it came from."""
    found = re.search(r"([^/\s]+\.(?:whl|tar\.gz|zip))", fault.split("DO NOT MATCH", 1)[1])
    return found and found[1].split("#", 1)[0]


def _download(some: list[Pin], store: Store) -> list[File] | str:
    """Download wheels with one call of pip: what was kept, or what pip said."""
    python = store.target.python
    abis = ["--abi", "cp" + python.replace(".", ""), "--abi", "abi3", "--abi", "none"]
    platforms = [word for name in store.target.platforms for word in ("--platform", name)]
    options = ["--only-binary", ":all:", *platforms, *abis]
    options += ["--python-version", python, "--implementation", "cp"]
    options += ["--ignore-requires-python"]  # the lock has decided; some packages guess an end
    with store.scratch() as folder:
        fault = _pip("download", some, folder, options)
        if fault:
            return fault
        wheels = {pin: path for pin in some for path in folder.iterdir() if path.suffix == ".whl"
                  and store.fits(path.name, pin)}  # fmt: skip
        absent = [pin.name for pin in some if pin not in wheels]
        if absent:
            return f"no file for {', '.join(absent)}"
        return [store.keep(path, pin) for pin, path in wheels.items()]


def _build(some: list[Pin], store: Store) -> list[File] | str:
    """Build the wheel of one source archive, without a compiler and without another download."""
    (pin,) = some
    with store.scratch() as folder:
        options = ["--no-binary", pin.name, "--no-build-isolation"]
        fault = _pip("download", some, folder, options, ("setuptools", "wheel"))
        if fault:
            return fault
        archive = next(path for path in folder.iterdir() if path.is_file())
        digest = f"sha256:{sha256(archive)}"
        if digest not in pin.hashes:
            raise RemoteError(f"{archive.name}: its sha256 is not one of the lock: it was not kept")
        say(f"wheelhouse: building {archive.name}")
        done = _run(
            [tools("pip", "setuptools", "wheel"), "-m", "pip", "wheel", "--no-deps", "--no-index",
             "--no-build-isolation", "--wheel-dir", str(folder / "made"), str(archive)],
        )  # fmt: skip
        made = [*(folder / "made").glob("*-none-any.whl")]
        if done.returncode or len(made) != 1:
            raise BackendError(
                f"{archive.name}: no wheel for every machine could be built of it "
                f"({_last_line(done.stderr)}); it is built by the setuptools of locks/build.txt"
            )
        return [store.keep_built(made[0], digest)]


def own_wheel(store: Store) -> File:
    """Build qRobot's own wheel of this checkout into the store; the same source, the same bytes."""
    with store.scratch() as folder:
        command = [tools("hatchling"), "-m", "hatchling", "build", "--target", "wheel"]
        done = _run([*command, "--directory", str(folder)], cwd=ROOT)
        made = [*folder.glob("qrobot-*.whl")]
        if done.returncode or len(made) != 1:
            raise BackendError(
                f"qRobot's own wheel could not be built ({_last_line(done.stderr)}); "
                "see pyproject.toml"
            )
        return store.put(made[0])


@cache
def tools(*names: str) -> str:
    """Return a Python that has these, in the versions of locks/build.txt: ours, or one made."""
    locked = {pin.name: pin.version for pin in pins(BUILD_LOCK.read_text(), "x86_64")}

    def here(name: str) -> bool:
        try:
            return importlib.metadata.version(name) == locked.get(
                name, importlib.metadata.version(name)
            )
        except importlib.metadata.PackageNotFoundError:
            return False

    return sys.executable if all(map(here, names)) else _made_tools()


def _made_tools() -> str:
    folder = ROOT / "build" / "wheelhouse-tools"
    python = folder / "bin" / "python"
    stamp = folder / f".{sha256(BUILD_LOCK)[:16]}"
    if not stamp.exists():
        say(f"wheelhouse: making {folder} with the build tools of locks/build.txt")
        steps = [
            [sys.executable, "-m", "venv", "--clear", str(folder)],
            [str(python), "-m", "pip", "--disable-pip-version-check", "--no-input", "--quiet",
             "install", "--require-hashes", "--requirement", str(BUILD_LOCK)],
        ]  # fmt: skip
        for step in steps:
            if _run(step).returncode:
                raise BackendError(
                    "the build tools of locks/build.txt are not installed here and could not be "
                    'fetched; run "make setup" with a network and use its Python'
                )
        stamp.touch()
    return str(python)


def _pip(
    verb: str, some: list[Pin], folder: Path, options: list[str], needs: tuple[str, ...] = ()
) -> str:
    """Let pip bring pins into a folder: nothing, or what it said where it failed."""
    asked = folder / "requirements"
    asked.write_text("".join(f"{line(pin.name, pin.version, pin.hashes)}\n" for pin in some))
    command = [tools("pip", *needs), "-m", "pip", "--disable-pip-version-check", "--no-input"]
    command += [verb, "--quiet", "--retries", "2", "--no-deps", "--require-hashes", *options]
    done = _run([*command, "--dest", str(folder), "--requirement", str(asked)])
    asked.unlink()
    return (done.stderr or "pip failed") if done.returncode else ""


def line(name: str, version: str, hashes: tuple[str, ...]) -> str:
    """Return a requirement as an installer reads it: its marker has been read already."""
    return f"{name}=={version} " + " ".join(f"--hash={value}" for value in hashes)


def _run(command: list[str], cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, cwd=cwd, env=os.environ | SAME_BYTES, umask=0o022,
        capture_output=True, text=True, check=False,
    )  # fmt: skip


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return re.sub(r"\S*:/{2}\S*", "...", lines[-1].strip()) if lines else "it said nothing"
