"""Every code block of every page is executed, or checked as far as a test can."""

from __future__ import annotations

import configparser
import csv
import inspect
import json
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from pages.blocks import OUTSIDE, PAGES, Block, blocks_of, name_of, prose_of
from pages.commands import (
    RUNNABLE,
    check_command,
    check_qrobot,
    check_syntax,
    check_variable,
    commands_of,
    extras_of_the_package,
)
from pages.reader import Reader, installed, masked

import qrobot
from qrobot.backends.registry import GROUP
from qrobot.cli.main import cli

pytestmark = pytest.mark.skipif(not PAGES, reason="the pages are not in a wheel")


@pytest.mark.slow
@pytest.mark.parametrize("page", [p for p in PAGES if blocks_of(p)], ids=name_of)
def test_the_blocks_of_a_page(page: Path, tmp_path: Path, subtests: pytest.Subtests) -> None:
    reader = Reader(tmp_path)
    for block in blocks_of(page):
        with subtests.test(msg=str(block)):
            prove(block, reader)
    run_here = (block for block in blocks_of(page, "python") if not block.mark.explained)
    reader.prove_suites("\n\n".join(block.text for block in run_here))


def prove(block: Block, reader: Reader) -> None:
    """Execute a block, or check what can be checked; skip after that when its extra is absent."""
    assert block.language in LANGUAGES, (
        f"{block}: '{block.language}' is not a language of the tests"
    )
    extras, outside = needs_of(block)
    check, run = LANGUAGES[block.language]
    check(block)
    if not outside and (absent := [extra for extra in extras if not installed(extra)]):
        pytest.skip(f"a page's block needs the extra {absent[0]}")
    if not outside and not block.mark.explained:
        run(block, reader)


def needs_of(block: Block) -> tuple[list[str], list[str]]:
    """Return the extras that a block needs, and what else."""
    extras = [name for name in block.mark.needs if name in extras_of_the_package()]
    outside = [name for name in block.mark.needs if name not in extras]
    unknown = set(outside) - OUTSIDE
    assert not unknown, f"{block}: {sorted(unknown)} are not things that a block can need"
    return extras, outside


# --- each language: what is always checked, and what is done where the needs are met --------------


def script_of(block: Block) -> tuple[str, str]:
    """Return the commands of a block, and what it shows of their output."""
    text = block.text
    if block.language != "console":
        return text, ""
    commands, shown = [], []
    going_on = False
    for line in text.splitlines():
        if line.startswith("$ ") or going_on:
            commands.append(line.removeprefix("$ "))
            going_on = line.endswith("\\")
        else:
            shown.append(line)
    assert commands, f"{block}: no line begins with '$ '; write ```sh"
    return "\n".join(commands) + "\n", "\n".join(shown)


def check_shell(block: Block) -> None:
    script, _ = script_of(block)
    check_syntax(script)
    for words in commands_of(script):
        check_command(words)


def run_shell(block: Block, reader: Reader) -> None:
    script, shown = script_of(block)
    for words in commands_of(script):
        assert words[0] in RUNNABLE, (
            f"{block}: '{words[0]}' is not run by tests; say what it needs in a comment before it"
        )
    reader.type(script)
    assert not shown or masked(shown) == masked(reader.printed)


def check_cron(block: Block) -> None:
    for line in block.text.splitlines():
        if not line or line.startswith("#") or re.match(r"\w+=", line):
            continue
        found = re.fullmatch(r"((?:[\d*/,-]+ +){5})(.*)", line)
        assert found, f"{block}: not a line of cron: {line}"
        command = found[2].removeprefix("robot ").strip()
        check_syntax(command)
        for words in commands_of(command):
            check_command(words)


def check_text(block: Block) -> None:
    assert block.mark.explained or block.mark.output_of, (
        f"{block}: say in a comment before it whether it is the output of a command or a drawing"
    )


def run_text(block: Block, reader: Reader) -> None:
    if block.mark.output_of.startswith("qrobot "):
        reader.type(block.mark.output_of)
    if block.mark.output_of:
        expected, printed = masked(block.text), masked(reader.printed)
        if block.mark.apart_from_numbers:
            expected, printed = (re.sub(r"\d[\d.,]*", "N", text) for text in (expected, printed))
        assert expected == printed


def check_python(block: Block) -> None:
    compile(block.text, str(block), "exec")


def run_python(block: Block, reader: Reader) -> None:
    reader.execute(block.text, str(block.page), block.line)


def check_json(block: Block) -> None:
    assert json.loads(block.text) is not None


def run_json(block: Block, reader: Reader) -> None:
    """Read an instance, whose layout is then that of the orders on the page."""
    document: Any = json.loads(block.text)
    if isinstance(document, dict) and document.get("schema") == "qrobot.instance/1":
        (reader.folder / "instance.json").write_text(block.text)
        assert qrobot.read(reader.folder / "instance.json").size
        if not (reader.folder / "layout.json").exists():
            layout = {k: v for k, v in document.items() if k not in {"items", "orders"}}
            (reader.folder / "layout.json").write_text(json.dumps(layout))


def check_csv(block: Block) -> None:
    rows = list(csv.reader(block.text.splitlines()))
    assert len({len(row) for row in rows}) == 1, f"{block}: rows of unlike length"


def run_csv(block: Block, reader: Reader) -> None:
    (reader.folder / "orders.csv").write_text(block.text)
    assert qrobot.read(reader.folder / "orders.csv").size == block.text.count("\n") - 1


def check_ini(block: Block) -> None:
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.read_string(block.text)
    assert set(unit.sections()) <= {"Unit", "Service", "Socket", "Timer", "Install"}


def entry_points(block: Block) -> dict[str, str]:
    """Return the backends that a block of pyproject.toml adds."""
    added: dict[str, dict[str, str]]
    added = tomllib.loads(block.text).get("project", {}).get("entry-points", {})
    assert set(added) <= {GROUP}
    return added.get(GROUP, {})


def check_toml(block: Block) -> None:
    """Hold the class of an entry point against those that the page defines."""
    sources = "".join(other.text for other in blocks_of(block.page, "python"))
    for name, value in entry_points(block).items():
        assert f"class {value.partition(':')[2]}" in sources
        assert f'name = "{name}"' in sources


def check_yaml(block: Block) -> None:
    yaml: Any = pytest.importorskip("yaml", reason="PyYAML is not installed")
    document = yaml.safe_load(block.text)
    assert document is not None
    if "all" in document:  # an inventory
        for name in variables_of(document["all"]):
            check_variable(name)


def variables_of(group: dict[str, Any]) -> Iterator[str]:
    """Return the variables that a group of an inventory and those below it set."""
    assert set(group) <= {"hosts", "vars", "children"}
    yield from group.get("vars") or {}
    for variables in (group.get("hosts") or {}).values():
        yield from variables or {}
    for child in (group.get("children") or {}).values():
        yield from variables_of(child or {})


def nothing(_block: Block, _reader: Reader) -> None:
    """What is checked need not be run."""


LANGUAGES: dict[str, tuple[Callable[[Block], None], Callable[[Block, Reader], None]]] = {
    "console": (check_shell, run_shell),
    "cron": (check_cron, nothing),
    "csv": (check_csv, run_csv),
    "ini": (check_ini, nothing),
    "json": (check_json, run_json),
    "python": (check_python, run_python),
    "sh": (check_shell, run_shell),
    "text": (check_text, run_text),
    "toml": (check_toml, nothing),
    "yaml": (check_yaml, nothing),
}


# --- commands in sentences and in --help ----------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_in_sentences(page: Path) -> None:
    added = [name for block in blocks_of(page, "toml") for name in entry_points(block)]
    for number, line in enumerate(prose_of(page).splitlines(), 1):
        for code in re.findall(r"(?<!`)`((?:qrobot|make) [^`]+)`", line):
            try:
                for words in commands_of(code):
                    if words[0] == "qrobot":
                        check_qrobot(words[1:], whole=False, more=added)
                    else:
                        check_command(words)
            except (AssertionError, ValueError) as error:
                raise AssertionError(f"{name_of(page)}:{number}: `{code}`: {error}") from None


def test_commands_in_helps() -> None:
    helps = "\n".join(inspect.cleandoc(one.help or "") for one in commands_below(cli))
    examples = re.findall(r"^ *(qrobot (?:.*\\\n)*.*)", helps, re.MULTILINE)
    assert len(examples) > 20
    for line in examples:
        for words in commands_of(line):
            check_command(words)


def commands_below(command: click.Command) -> Iterator[click.Command]:
    """Return a command and those below it."""
    yield command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            yield from commands_below(below)
