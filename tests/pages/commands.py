"""What a line of shell calls, checked without running it.

Options and subcommands of ``qrobot`` are held against click's own parser, targets and variables of
``make`` against the Makefile, files, extras and variables of the playbooks against the project.
"""

from __future__ import annotations

import functools
import re
import shlex
import subprocess
import tomllib
from collections.abc import Iterable
from pathlib import Path
from unittest import mock

import click
from pages.blocks import ROOT

from qrobot.backends import registry
from qrobot.cli.main import cli
from qrobot.errors import QRobotError

__all__ = [
    "RUNNABLE",
    "check_command",
    "check_make",
    "check_qrobot",
    "check_syntax",
    "check_variable",
    "commands_of",
    "extras_of_the_package",
]

RUNNABLE = {".", "cat", "cd", "cp", "echo", "export", "ls", "make", "mkdir", "python", "qrobot"}
"""What a block may call to be run: nothing that reaches out of its folder."""

KEYWORDS = {"do", "done", "else", "fi", "if", "then", "while", "!", "{", "}"}
FOLDERS = ("ansible/", "benchmarks/", "docker/", "docs/", "examples/", "healthchecks/", "locks/")
RELEASE = ROOT / "ansible/plugins/module_utils/qrobot_release/program.py"
MADE = ("ansible/inventory/", "ansible/inventory")
"""What the reader makes in those folders."""


def check_syntax(text: str) -> None:
    """Let bash read a script without running it."""
    done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr  # noqa: PT018


def commands_of(text: str) -> list[list[str]]:
    """Return the words of every simple command of a script."""
    found: list[list[str]] = []
    for line in text.replace("\\\n", " ").splitlines():
        line = re.sub(r"(?<=\s)\d(?=[<>])", "", line)  # 2>&1: a number of a stream is no word
        scanner = shlex.shlex(line, posix=True, punctuation_chars="();<>|&")
        scanner.whitespace_split = True
        words: list[str] = []
        redirected = False
        for word in [*scanner, ";"]:
            if set(word) <= set("<>&") and set(word) & set("<>"):
                redirected = True
            elif set(word) <= set("();|&"):
                if words and words[0] != "for":
                    found.append(words)
                words, redirected = [], False
            elif redirected:
                redirected = False
            elif words or not (word in KEYWORDS or re.match(r"\w+=", word)):
                words.append(word)
    return found


def check_command(words: list[str]) -> None:
    """Hold a command, whatever it is wrapped in, against what the project has."""
    for word in words:
        _check_file(word)
    name = Path(words[0]).name
    if name == "make":
        check_make(words[1:])
    elif name in {"pip", "uv"}:
        for extras in re.findall(r"qrobot\[([\w,-]+)\]", " ".join(words)):
            unknown = set(extras.split(",")) - set(extras_of_the_package())
            assert not unknown, f"pyproject.toml has no extra {', '.join(sorted(unknown))}"
    elif name not in {"git", "cd"}:
        for at in range(len(words)):
            if _check_program(words[at], words[at + 1 :], words[:at]):
                return


def _check_program(program: str, words: list[str], before: list[str]) -> bool:
    """Hold the words after a program of ours against it; tell whether it was one."""
    if Path(program).name == "qrobot":
        check_qrobot(words)
    elif program.startswith("qrobot:lab"):
        pass  # starts JupyterLab; tests/images hold what it takes
    elif program.startswith("qrobot:"):  # an image, whose entry point is the command
        check_qrobot([] if "--entrypoint" in before else words)
    elif program == "qrobot-release":
        check_spelled(words[:1], RELEASE.read_text(), program)
    elif program.endswith((".py", ".sh")) and (ROOT / program).is_file():
        options = [word.partition("=")[0] for word in words if word.startswith("--")]
        check_spelled(options, spelled_beside(ROOT / program), program)
    else:
        return False
    return True


def check_spelled(words: list[str], source: str, program: str) -> None:
    for word in words:
        assert f'"{word}"' in source or f"'{word}'" in source, f"{program} does not know {word}"


def spelled_beside(path: Path) -> str:
    """Return the source of a script and of the modules of its folder, which it may ask."""
    return "\n".join(other.read_text() for other in path.parent.glob(f"*{path.suffix}"))


def _check_file(word: str) -> None:
    path = word.removeprefix("./").partition("=")[2] or word.removeprefix("./")
    if path.startswith(FOLDERS) and not path.startswith(MADE) and not set(path) & set("*$?"):
        assert (ROOT / path).exists(), f"the project has no {path}"


# --- qrobot ---------------------------------------------------------------------------------------


def check_qrobot(words: list[str], *, whole: bool = True, more: Iterable[str] = ()) -> None:
    """Let click read the words without calling anything; files need not be there.

    What is not `whole` may name a command without any argument, as a sentence does. `more` are
    backends that the page itself adds.
    """
    seen: list[click.Context] = []
    with mock.patch.object(click.Command, "invoke", lambda _, context: seen.append(context)):
        try:
            cli.main(list(words), prog_name="qrobot", standalone_mode=False)
        except (click.MissingParameter, click.exceptions.NoArgsIsHelpError) as error:
            path = error.ctx.command_path.split()[1:] if error.ctx else []
            bare = [word for word in words[len(path) :][:1] if not word.startswith("-")] == []
            assert bare and not whole, error.format_message()  # noqa: PT017, PT018
        except (click.ClickException, QRobotError) as error:
            said = error.format_message() if isinstance(error, click.ClickException) else error
            raise AssertionError(f"qrobot {shlex.join(words)}: {said}") from None
    for context in seen:
        for parameter in ("backend", "backends", "fallback"):
            for name in filter(None, str(context.params.get(parameter) or "").split(",")):
                assert name in {"auto", *registry.BUILTIN, *more}, f"'{name}' is not a backend"


# --- make and the playbooks -----------------------------------------------------------------------


def check_make(words: list[str]) -> None:
    """Hold targets and variables against the Makefile, and what it hands on to Ansible."""
    text = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z][\w-]*):", text, re.MULTILINE))
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            assert word in targets or word.startswith("-"), f"the Makefile has no target {word}"
            continue
        assert re.search(rf"\b{name}\b", text), f"the Makefile has no variable {name}"
        if name == "ANSIBLE_ARGS":
            check_ansible(shlex.split(value))


def check_ansible(words: list[str]) -> None:
    """Hold the variables that are set for playbooks against those that they read."""
    for at, word in enumerate(words):
        if word in {"-e", "--extra-vars"}:
            for name in re.findall(r"(?:^|[\s{,])\"?([a-z]\w*)\"?[=:]", words[at + 1]):
                check_variable(name)


def check_variable(name: str) -> None:
    """Raise when no playbook or role reads a variable."""
    if not name.startswith("ansible_"):
        assert name in names_in_ansible(), f"no playbook reads {name}"


@functools.cache
def names_in_ansible() -> frozenset[str]:
    texts = [p.read_text() for p in (ROOT / "ansible").rglob("*.y*ml") if ".ansible" not in p.parts]
    return frozenset(name for text in texts for name in re.findall(r"\b[a-z]\w+\b", text))


@functools.cache
def extras_of_the_package() -> dict[str, list[str]]:
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras: dict[str, list[str]] = tomllib.load(file)["project"]["optional-dependencies"]
    return extras
