"""The fenced blocks of a Markdown page, and what the page says about testing them.

A page may say something about the block that follows, in a comment that is not rendered:

``<!-- test: needs docker, robots -->``
    What a machine must have. An extra of the package (``qiskit``, ``edge``) is looked for, and the
    block runs where it is installed; anything else is in `OUTSIDE`, and the block is only checked.
``<!-- test: output of `qrobot solve ...` -->``
    The text is what the command prints, apart from times.
``<!-- test: output of the block above, apart from numbers -->``
    The same, of the last block that ran; here the numbers depend on the machine.
``<!-- test: held by tests/FILE.py -->``
    A test of its own holds what the text says.
``<!-- test: drawing -->``
    The text is a picture or a list for people.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

__all__ = ["OUTSIDE", "PAGES", "ROOT", "Block", "Mark", "blocks_of", "name_of", "prose_of"]

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    page
    for pattern in ("*.md", "docs/**/*.md", "examples/*.md", "healthchecks/*.md", "locks/*.md")
    for page in ROOT.glob(pattern)
    if not page.name.endswith("-plan.md")  # of what is not there yet
)

OUTSIDE = {
    "another machine", "credentials", "docker", "network", "robots", "root", "terminal",
    "time", "wheels",
}  # fmt: skip
"""What no test provides: a block that needs one of these is checked and not run."""

FENCE = re.compile(r"(?P<indent> *)(?P<fence>```+|~~~+) *(?P<language>[\w+-]*)[^`]*$")
ABOVE = "the block above"
MARK = re.compile(r"\s*<!-- test: (?P<words>.*) -->\s*$")


@dataclass(frozen=True)
class Mark:
    """What a page says about testing a block."""

    needs: tuple[str, ...] = ()
    output_of: str = ""
    apart_from_numbers: bool = False
    explained: bool = False
    """A drawing, or what another test holds."""

    @classmethod
    def read(cls, words: str) -> Mark:
        """Return what these words say; unknown ones are a fault of the page."""
        if words == "drawing":
            return cls(explained=True)
        if (found := re.fullmatch(r"held by (tests/\S+\.py)", words)) and (
            ROOT / found[1]
        ).exists():
            return cls(explained=True)
        if found := re.fullmatch(
            r"output of (?:`(.+)`|the block above)(, apart from numbers)?", words
        ):
            return cls(output_of=found[1] or ABOVE, apart_from_numbers=bool(found[2]))
        if words.startswith("needs "):
            return cls(needs=tuple(word.strip() for word in words[6:].split(",")))
        raise ValueError(f"'{words}' says nothing about a test; see tests/pages/blocks.py")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    """Of the first line of the text, counted from 1."""
    language: str
    text: str
    mark: Mark

    def __str__(self) -> str:
        return f"{name_of(self.page)}:{self.line}"


def name_of(page: Path) -> str:
    """Return the page as it is called in messages."""
    return str(page.relative_to(ROOT)) if page.is_relative_to(ROOT) else page.name


def blocks_of(page: Path, language: str | None = None) -> list[Block]:
    """Return the blocks of a page (of a language), in the order of the page."""
    found = _parse(page, page.read_text())
    return [block for block in found if language in (None, block.language)]


def _parse(page: Path, text: str) -> Iterator[Block]:
    lines = iter(enumerate(text.splitlines(), 1))
    mark: tuple[int, Mark] | None = None
    for number, line in lines:
        if found := MARK.match(line):
            mark = number, Mark.read(found["words"])
        elif found := FENCE.match(line):
            where = f"{name_of(page)}:{number}"
            text = "".join(_body(lines, found["fence"], len(found["indent"]), where))
            yield Block(
                page, number + 1, found["language"].lower(), text, mark[1] if mark else Mark()
            )
            mark = None
        elif line.strip() and mark:
            raise ValueError(f"{name_of(page)}:{mark[0]}: no block follows this comment")


def _body(lines: Iterator[tuple[int, str]], fence: str, indent: int, where: str) -> Iterator[str]:
    for _, line in lines:
        if line.strip().startswith(fence) and not line.strip().strip(fence[0]):
            return
        yield f"{line[:indent].lstrip(' ')}{line[indent:]}\n"
    raise ValueError(f"{where}: the block has no end")


def prose_of(page: Path) -> str:
    """Return the page without its blocks; the lines keep their numbers."""
    kept = page.read_text().splitlines()
    for block in blocks_of(page):
        size = block.text.count("\n")
        kept[block.line - 2 : block.line + size] = [""] * (size + 2)
    return "\n".join(kept)
