"""Which instructions of the wheels a Raspberry Pi 4 lacks, and why each is safe nevertheless.

A Cortex-A72 dies of an instruction that it does not know. Libraries hold such instructions and ask
the processor before they use them; no program can prove that they do. So each finding must be in
instructions.toml, where somebody who looked gives the reason; one that is not there is told, and
``make wheelhouse`` fails. What compilers make of themselves is known without a review: atomic
helpers that ask first, and the unwinder of GCC's library.

Usage: instructions.py [WHEEL or FOLDER ...]     the default is build/wheelhouse/files
Exit codes: 0 all are reviewed, 2 a file cannot be used, 3 one is not reviewed.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import a64
import elf
import numpy as np
import numpy.typing as npt
from common import ROOT, read_json, run, say, sha256, write_json
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

from qrobot.errors import BackendError, InputError

REVIEWED = Path(__file__).with_name("instructions.toml")
SCANNER = 1
"""Another number when the scan would find something else: what was found before is forgotten."""


@dataclass(frozen=True)
class Finding:
    """Instructions of one kind in one file of a wheel.

    Parameters
    ----------
    package, file
        Where they are.
    kind
        A name of `a64.CLASSES`, or ``unreadable`` for a file that could not be searched.
    sure
        How many surely are instructions.
    possible
        How many may be data: the file does not tell.
    first
        Address of the first one in memory, for ``objdump --start-address``.
    asks
        Ways to ask for the processor's features that the file names.
    """

    package: str
    file: str
    kind: str
    sure: int
    possible: int
    first: int
    asks: str

    def __str__(self) -> str:
        count = f"{self.sure} of the kind {self.kind}" if self.sure else f"perhaps {self.kind}"
        return f"{self.package}: {self.file}: {count}, the first at 0x{self.first:x}"


@dataclass(frozen=True)
class Review:
    """Why instructions of a package are safe on a processor that lacks them."""

    package: str
    kinds: tuple[str, ...]
    reason: str
    files: str = "*"

    def covers(self, finding: Finding) -> bool:
        return (
            self.package == finding.package
            and finding.kind in self.kinds
            and fnmatchcase(finding.file, self.files)
        )


def search(package: str, name: str, data: bytes) -> Iterator[Finding]:
    """Yield what one program or library holds, but for what needs no review."""
    asks = ", ".join(elf.asks(data))
    totals: dict[str, list[int]] = {}
    try:
        for part in elf.code(data):
            text = ~part.sure & a64.is_text(part.words)
            for kind, places in a64.find(part.words).items():
                left = places[~(text[places] | _harmless(kind, part.words, places))]
                if not len(left):
                    continue
                sure = int(part.sure[left].sum())
                first = part.address + 4 * int(left[np.argmax(part.sure[left])])
                total = totals.setdefault(kind, [0, 0, first])
                total[0] += sure
                total[1] += len(left) - sure
    except elf.ElfError:
        yield Finding(package, name, "unreadable", 0, 0, 0, asks)
    for kind, (sure, possible, first) in totals.items():
        yield Finding(package, name, kind, sure, possible, first, asks)


def _harmless(kind: str, words: a64.Words, places: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Which places need no review: what compilers guard themselves."""
    if kind == "lse":
        return a64.outlined(words, places)
    if kind == "sve":
        return np.asarray(words[places] == a64.CNTD_X0)
    return np.zeros(len(places), dtype=bool)


def scan_wheel(path: Path) -> list[Finding]:
    """Return what the programs and libraries of a wheel hold.

    Raises
    ------
    InputError
        When it is not a wheel.
    """
    try:
        package = parse_wheel_filename(path.name)[0]
        with zipfile.ZipFile(path) as wheel:
            found: list[Finding] = []
            for entry in wheel.infolist():
                with wheel.open(entry) as file:
                    head = file.read(20)
                    if elf.is_aarch64(head):
                        found += search(package, entry.filename, head + file.read())
            return found
    except (InvalidWheelFilename, zipfile.BadZipFile):
        raise InputError("not a wheel", source=str(path), advice="give a .whl file") from None
    except OSError as error:
        raise InputError(f"not readable ({error.strerror})", source=str(path)) from None


def scan(paths: Iterable[Path], cache: Path) -> list[Finding]:
    """Return what wheels hold; each is searched once, and remembered by its hash."""
    known = read_json(cache)
    if not isinstance(known, dict) or known.get("scanner") != SCANNER:
        known = {"scanner": SCANNER, "wheels": {}}
    found: list[Finding] = []
    fresh = False
    for path in paths:
        key = sha256(path)
        if key not in known["wheels"]:
            known["wheels"][key] = [asdict(one) for one in scan_wheel(path)]
            fresh = True
        found += [Finding(**one) for one in known["wheels"][key]]
    if fresh:
        write_json(cache, known)
    return found


def reviews(path: Path = REVIEWED) -> list[Review]:
    """Return what was reviewed.

    Raises
    ------
    InputError
        When the file is not of that form.
    """
    try:
        entries = tomllib.loads(path.read_text())["safe"]
        found = [Review(**{**one, "kinds": tuple(one["kinds"])}) for one in entries]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"cannot be used ({error})", source=str(path)) from None
    for one in found:
        unknown = [kind for kind in one.kinds if kind not in (*a64.CLASSES, "unreadable")]
        if unknown or not one.reason.strip():
            problem = f"{unknown[0]} is not a kind" if unknown else "a reason is missing"
            raise InputError(problem, source=str(path), field=one.package)
    return found


def unreviewed(found: Iterable[Finding], known: list[Review]) -> list[str]:
    """Return a sentence for each finding that nobody has looked at."""
    return [
        f"{one}; a Pi 4 lacks it and no review says why it is safe: look at it with objdump and "
        f"add it to {REVIEWED.name}, or take another version"
        for one in found
        if not any(review.covers(one) for review in known)
    ]


def table(found: list[Finding], known: list[Review]) -> Iterator[str]:
    """Yield one line a package and reason: kinds with their counts, and the reason."""
    rows: dict[tuple[str, str], dict[str, int]] = {}
    for one in found:
        reason = next((r.reason for r in known if r.covers(one)), "NOT REVIEWED")
        kinds = rows.setdefault((one.package, reason), {})
        kinds[one.kind] = kinds.get(one.kind, 0) + one.sure + one.possible
    for (package, reason), kinds in sorted(rows.items()):
        counts = ", ".join(f"{kind} {count:,}" for kind, count in sorted(kinds.items()))
        yield f"{package}: {counts}: {reason}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("wheels", type=Path, nargs="*", default=[ROOT / "build/wheelhouse/files"])
    given: list[Path] = []
    for path in parser.parse_args().wheels:
        given += sorted(path.glob("*.whl")) if path.is_dir() else [path]
    if not given:
        raise InputError("wheels are missing", field="WHEEL", advice="run `make wheelhouse`")
    known = reviews()
    found = [one for path in given for one in scan_wheel(path)]
    for line in table(found, known):
        print(line)
    missing = unreviewed(found, known)
    for sentence in missing:
        say(f"instructions: {sentence}")
    if missing:
        raise BackendError(f"{len(missing)} findings are not reviewed")


if __name__ == "__main__":
    sys.exit(run("instructions", main))
