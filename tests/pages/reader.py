"""A reader of a page: a folder as a checkout is, a home of his own, and what he types."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import types
from pathlib import Path

import started
from card.made import KEY
from pages.blocks import ROOT
from pages.commands import extras_of_the_package

__all__ = ["Reader", "installed", "masked"]

MODULES = {
    "qiskit": "qiskit_aer", "ibm": "qiskit_ibm_runtime", "pennylane": "pennylane_lightning",
    "braket": "braket.devices", "dwave": "dwave.system", "docplex": "docplex", "plot": "matplotlib",
    "planners": "pyvrp", "lab": "nbclient",
}  # fmt: skip
"""By what an extra shows that it is installed."""

CARD = "/media/me/bootfs"
SHORT = 0.3
"""Seconds that a search gets in place of those of the page."""

QROBOT = f"""#!{sys.executable}
import sys
words = sys.argv[1:]
short = {{"--deadline": "{SHORT}", "-t": "{SHORT}", "--seeds": "1"}}
for at, word in enumerate(words):
    words[at + 1 : at + 2] = [short.get(word, other) for other in words[at + 1 : at + 2]]
limits = {{"--deadline", "-t", "--max-work", "--dry-run", "--no-wait"}}
if words[:1] == ["solve"] and not limits & set(words):
    words += ["-t", "{SHORT}"]
if words[:1] == ["health"] and not {{"compare", "merge", "--list"}} & set(words):
    words.insert(1, "--no-system")  # this machine may have faults of its own
import started
started.hand_over(words, "DOOR")
"""
"""The command, which gives searches less time than the page does."""

MAKE = f"""#!{sys.executable}
import sys
from pages.commands import check_make
check_make(sys.argv[1:])
"""
"""Has the target? What targets do is proven by tests of their own."""

PYTHON = f"""#!/bin/sh
exec {sys.executable} "$@"
"""


def installed(extra: str) -> bool:
    """Tell whether an extra of the package is installed, and all that it asks for."""
    inner = [
        name
        for requirement in extras_of_the_package()[extra]
        if requirement.startswith("qrobot[")
        for name in requirement[7:-1].split(",")
    ]
    if extra not in MODULES:
        return bool(inner) and all(installed(name) for name in inner)
    try:
        found = importlib.util.find_spec(MODULES[extra]) is not None
    except ModuleNotFoundError:
        return False
    return found and all(installed(name) for name in inner)


def masked(text: str) -> str:
    """Return a text without its times, the paths of a reader and the width of its columns."""
    text = re.sub(r"\b\d+(\.\d+)? s\b", "TIME", text)
    return re.sub(r"-{2,}", "--", re.sub(r" +", " ", text)).strip()


class Reader:
    """Types what a page says, in a folder that looks like a fresh checkout."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "qrobot"
        self.home = folder / "home"
        self.card = folder / "bootfs"
        self.printed = ""
        self._page = types.ModuleType("page")
        self._lay_out(folder / "bin")
        self._environment = {
            "HOME": str(self.home),
            "PATH": f"{folder / 'bin'}:/usr/bin:/bin",
            "PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}",
            "LANG": "C.UTF-8",
            "COLUMNS": "100",
            "QROBOT_HELPERS": "0",
        }

    def _lay_out(self, programs: Path) -> None:
        for path in (self.home / ".ssh", self.card, self.folder / ".venv/bin", programs):
            path.mkdir(parents=True)
        for name in ("examples", "ansible/inventory.example", "healthchecks"):
            shutil.copytree(ROOT / name, self.folder / name)
        (self.folder / ".venv/bin/activate").touch()
        (self.home / ".ssh/id_ed25519.pub").write_text(KEY + "\n")
        for name in ("cmdline.txt", "config.txt", "user-data", "network-config", "meta-data"):
            (self.card / name).touch()
        for name, text in (("qrobot", QROBOT), ("make", MAKE), ("python", PYTHON)):
            (programs / name).write_text(text.replace("DOOR", started.door()))
            (programs / name).chmod(0o755)

    def type(self, script: str) -> None:
        """Run a script; a command that fails fails."""
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", script.replace(CARD, str(self.card))],
            cwd=self.folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        self.printed = done.stdout.replace(str(self.card), CARD)
        assert done.returncode == 0, f"code {done.returncode}\n{done.stderr}\n{done.stdout}"

    def execute(self, source: str, name: str, line: int) -> None:
        """Execute Python in the namespace of the page; tracebacks name its lines."""
        text = re.sub(r"deadline=\d+(\.\d+)?", f"deadline={SHORT}", source)
        before = Path.cwd()
        sys.modules[self._page.__name__] = self._page
        os.chdir(self.folder)
        try:
            exec(compile("\n" * (line - 1) + text, name, "exec"), self._page.__dict__)
        finally:
            os.chdir(before)
            del sys.modules[self._page.__name__]

    def prove_suites(self, source: str) -> None:
        """Let pytest run the classes of tests that a page defines."""
        if any(name.startswith("Test") for name in vars(self._page)):
            future = "from __future__ import annotations\n"  # only a file's first statement
            (self.folder / "test_page.py").write_text(future + source.replace(future, ""))
            self.type("python -m pytest -q -p no:cacheprovider test_page.py")
