"""The tests of the pages find what is wrong with a block."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest
from pages import test_blocks
from pages.blocks import blocks_of, prose_of
from pages.commands import check_command, check_qrobot, check_syntax, commands_of
from pages.reader import Reader, masked


def prove(page: Path, text: str) -> None:
    """Prove every block of a page that is made up of this."""
    page.write_text(textwrap.dedent(text).lstrip())
    reader = Reader(page.parent)
    for block in blocks_of(page):
        test_blocks.prove(block, reader)


WRONG = {
    "a language nobody knows": ("```perl\nprint 1\n```", "'perl' is not a language"),
    "no language": ("```\nqrobot solve x\n```", "'' is not a language"),
    "text that is not explained": ("```text\n3 trips\n```", "say in a comment"),
    "another output": (
        "```sh\necho 3 trips\n```\n<!-- test: output of the block above -->\n```text\n4 trips\n```",
        "4 trips",
    ),
    "another output in a console": ("```console\n$ echo 3\n4\n```", "'4' == '3'"),
    "a failing command": ("```sh\nqrobot check missing.json missing.json\n```", "code 2"),
    "a failing command in the middle": ("```sh\ncat missing\necho done\n```", "code 1"),
    "a command that reaches out": ("```sh\ndocker run --rm x\n```", "'docker' is not run by tests"),
    "an option in a marked block": (
        "<!-- test: needs docker -->\n```sh\ndocker run qrobot:edge solve x --speed 3\n```",
        "No such option '--speed'",
    ),
    "a need that nobody knows": ("<!-- test: needs luck -->\n```sh\necho 1\n```", "luck"),
    "a comment that says nothing": ("<!-- test: later -->\n```sh\necho 1\n```", "says nothing"),
    "a comment before no block": ("<!-- test: drawing -->\n\nwords", "no block follows"),
    "a block without an end": ("```sh\necho 1\n", "has no end"),
    "a target": ("```sh\nmake coffee\n```", "no target coffee"),
    "Python that fails": ("```python\nassert 1 == 2\n```", ""),
    "Python without a name": ("```python\nx = 1\n```\n```python\nprint(y)\n```", "'y'"),
    "JSON": ("```json\n{\"a\": 1,}\n```", ""),
    "an instance": (
        '```json\n{"schema": "qrobot.instance/1", "items": []}\n```',
        "",
    ),
    "CSV": ("```csv\na,b\n1\n```", "unlike length"),
    "a line of cron": ("```cron\n99 * * * qrobot health\n```", "not a line of cron"),
    "an option in cron": ("```cron\n1 * * * * qrobot health --yes\n```", "No such option '--yes'"),
    "an entry point": (
        '```toml\n[project.entry-points."qrobot.backends"]\nx = "mine:X"\n```',
        "class X",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", WRONG)
def test_a_wrong_block_fails(fault: str, tmp_path: Path) -> None:
    text, told = WRONG[fault]
    with pytest.raises(Exception) as caught:  # noqa: PT011
        prove(tmp_path / "page.md", text)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("make provision LIMIT=x SPEED=3", "no variable SPEED"),
        ("make upgrade ANSIBLE_ARGS='-e qrobot_colour=red'", "no playbook reads qrobot_colour"),
        ("""make upgrade ANSIBLE_ARGS="-e '{\\"qrobot_colour\\": 1}'" """, "no playbook reads"),
        ("pip install 'qrobot[cobol]'", "no extra cobol"),
        ("ssh pi@picker sudo qrobot-release explode", "does not know explode"),
        ("ssh pi@picker qrobot helth", "No such command 'helth'"),
        ("sudo env HOME=x ansible/virtual-pi/nowhere.sh", "no ansible/virtual-pi/nowhere.sh"),
        ("python ansible/controller/wheelhouse.py --colour red", "does not know --colour"),
        ("qrobot solve x.json -b dwave-qpx", "'dwave-qpx' is not a backend"),
        ("qrobot solve x.json -t soon", "not a valid float"),
        ("qrobot solve x.json --robots many", "'many'"),
        ("qrobot solve x.json -O layers", "name=value"),
        ("qrobot solve x.json y.json", "unexpected extra argument"),
        ("qrobot jobs fetch", "Missing"),
        ("qrobot health --jobs many", "not a valid integer"),
    ],
)  # fmt: skip
def test_a_wrong_command_fails_without_being_run(command: str, told: str) -> None:
    check_syntax(command)
    ((*words,),) = commands_of(command)
    with pytest.raises(AssertionError) as caught:
        check_command(words)
    assert told in str(caught.value)


def test_a_sentence_may_name_a_command_but_not_half_of_its_arguments() -> None:
    check_qrobot(["check"], whole=False)
    check_qrobot(["solve", "--backend", "neal"], whole=False)
    with pytest.raises(AssertionError, match="INSTANCE"):
        check_qrobot(["check", "plan.json"], whole=False)


@pytest.mark.parametrize("script", ["for x in 1 2; do echo $x", "echo 'open", "if true; then"])
def test_a_script_that_bash_cannot_read_fails(script: str) -> None:
    with pytest.raises(AssertionError):
        check_syntax(script)


def test_the_commands_of_a_script() -> None:
    script = r"""
    (umask 077; openssl rand -hex 24 >~/token)
    for pi in a b; do ssh $pi qrobot health --json > reports/$pi.json; done   # comment
    IMAGE=x/y docker buildx \
      bake --push 2>&1 | tail -n 3 && . .venv/bin/activate
    """
    assert commands_of(script) == [
        ["umask", "077"],
        ["openssl", "rand", "-hex", "24"],
        ["ssh", "$pi", "qrobot", "health", "--json"],
        ["docker", "buildx", "bake", "--push"],
        ["tail", "-n", "3"],
        [".", ".venv/bin/activate"],
    ]


def test_blocks_keep_their_lines_and_lose_the_indent_of_a_list(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("1. Do:\n\n   ```sh\n   if x; then\n     y\n   fi\n   ```\n\n`qrobot z`\n")
    (block,) = blocks_of(page)
    assert (block.line, block.text) == (4, "if x; then\n  y\nfi\n")
    assert prose_of(page).splitlines() == ["1. Do:", *[""] * 7, "`qrobot z`"]


def test_times_and_widths_do_not_count() -> None:
    assert masked("exact in 0.00 s,  done\n-----") == masked("exact in 12.5 s, done\n---\n")
    assert masked("3 trips") != masked("4 trips")
