"""Where the instructions of an AArch64 program or library are, and which words surely are some."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

AARCH64 = 183
EXECUTABLE_SECTION = 4
SYMBOLS = (2, 11)  # SHT_SYMTAB, SHT_DYNSYM
FUNCTIONS = (2, 10)  # STT_FUNC, STT_GNU_IFUNC
SYMBOL = np.dtype(
    [("name", "<u4"), ("info", "u1"), ("other", "u1"), ("section", "<u2"), ("value", "<u8"),
     ("size", "<u8")]
)  # fmt: skip
Spans = npt.NDArray[np.int64]


class ElfError(Exception):
    """The file begins as one of AArch64, and its tables lead nowhere."""


@dataclass(frozen=True)
class Section:
    """A part of the file that has a name and a place in memory."""

    name: str
    kind: int
    flags: int
    address: int
    data: memoryview


@dataclass(frozen=True)
class Code:
    """Executable words.

    Parameters
    ----------
    address
        Where the first one lies in memory.
    words
        The words.
    sure
        Which of them are instructions by what the file tells: unwinding tables, symbols, mapping
        symbols. The others may be data between them.
    """

    address: int
    words: npt.NDArray[np.uint32]
    sure: npt.NDArray[np.bool_]


def is_aarch64(data: bytes | memoryview) -> bool:
    """Tell whether a file is a program or library of a 64-bit ARM machine."""
    head = bytes(data[:20])
    return (
        head[:6] == b"\x7fELF\x02\x01"
        and len(head) == 20
        and struct.unpack_from("<H", head, 18)[0] == AARCH64
    )


def code(data: bytes) -> Iterator[Code]:
    """Yield the executable parts of a file.

    Raises
    ------
    ElfError
        When its tables cannot be read.
    """
    try:
        sections = list(_sections(memoryview(data)))
        starts, ends = _known(sections)
        marks = _marks(sections)
        for part in _executable(memoryview(data), sections):
            words = np.frombuffer(part.data, "<u4", len(part.data) // 4)
            sure = _covered(part.address, len(words), starts, ends)
            for (address, is_code), (end, _) in pairwise([*marks, (1 << 62, False)]):
                first, last = ((one - part.address) // 4 for one in (address, end))
                if first < len(words) and last > 0:
                    sure[max(first, 0) : last] = is_code
            yield Code(part.address, words, sure)
    except (struct.error, ValueError, IndexError) as error:
        raise ElfError(str(error)) from None


def asks(data: bytes) -> list[str]:
    """Ways to ask for the processor's features that a file names: what guards may rest on."""
    known = (b"getauxval", b"elf_aux_info", b"/proc/cpuinfo", b"/proc/self/auxv")
    return [name.decode() for name in known if name in data]


def _sections(data: memoryview) -> Iterator[Section]:
    (offset,) = struct.unpack_from("<Q", data, 0x28)
    size, count, names = struct.unpack_from("<HHH", data, 0x3A)
    heads = [struct.unpack_from("<IIQQQQ", data, offset + i * size) for i in range(count)]
    if not heads:
        return
    text = bytes(data[heads[names][4] : heads[names][4] + heads[names][5]])
    for name, kind, flags, address, place, length in heads:
        label = text[name : text.index(b"\0", name)].decode(errors="replace")
        yield Section(
            label, kind, flags, address, data[place : place + length if kind != 8 else place]
        )


def _executable(data: memoryview, sections: list[Section]) -> Iterator[Section]:
    """Sections with instructions; segments, where a file has lost its sections."""
    found = [one for one in sections if one.flags & EXECUTABLE_SECTION and len(one.data) >= 4]
    yield from found
    if found:
        return
    (offset,) = struct.unpack_from("<Q", data, 0x20)
    size, count = struct.unpack_from("<HH", data, 0x36)
    for i in range(count):
        kind, flags, place, address, _, length = struct.unpack_from(
            "<IIQQQQ", data, offset + i * size
        )
        if kind == 1 and flags & 1:
            yield Section("", 1, EXECUTABLE_SECTION, address, data[place : place + length])


def _known(sections: list[Section]) -> tuple[Spans, Spans]:
    """Begins and ends of what surely is code: functions of tables for unwinding and of symbols."""
    found = [pair for one in sections if one.name == ".eh_frame" for pair in _unwound(one)]
    spans = [np.array(found, dtype=np.int64).reshape(-1, 2)]
    for table in (one for one in sections if one.kind in SYMBOLS):
        symbols = _symbols(table)
        chosen = symbols[np.isin(symbols["info"] & 15, FUNCTIONS) & (symbols["size"] > 0)]
        begins = chosen["value"].astype(np.int64)
        spans.append(np.stack([begins, begins + chosen["size"].astype(np.int64)], axis=1))
    pairs = np.concatenate(spans)
    return pairs[:, 0], pairs[:, 1]


def _symbols(table: Section) -> npt.NDArray[np.void]:
    return np.frombuffer(table.data, SYMBOL, len(table.data) // SYMBOL.itemsize)


def _marks(sections: list[Section]) -> list[tuple[int, bool]]:
    """Mapping symbols in their sequence: where instructions begin (``$x``) and data (``$d``)."""
    names = next((bytes(one.data) for one in sections if one.name == ".strtab"), b"") + b"\0\0\0"
    text = np.frombuffer(names, np.uint8)
    marks: list[tuple[int, bool]] = []
    for table in (one for one in sections if one.kind == SYMBOLS[0]):
        symbols = _symbols(table)
        at = np.minimum(symbols["name"], len(text) - 3)
        found = symbols[(text[at] == ord("$")) & np.isin(text[at + 2], (0, ord(".")))]
        kinds = text[found["name"] + 1]
        kept = np.isin(kinds, (ord("x"), ord("d")))
        marks += zip(found["value"][kept].tolist(), (kinds[kept] == ord("x")).tolist(), strict=True)
    return sorted(marks)


def _covered(address: int, count: int, starts: Spans, ends: Spans) -> npt.NDArray[np.bool_]:
    """Which of the words from an address lie in one of the spans."""
    edges = np.zeros(count + 1, dtype=np.int64)
    first = np.clip((starts - address) // 4, 0, count)
    last = np.clip((ends - address + 3) // 4, 0, count)
    np.add.at(edges, first, 1)
    np.add.at(edges, last, -1)
    return np.cumsum(edges[:-1]) > 0


# Tables for unwinding (Linux Standard Base, "Exception Frames"; DWARF 5, 6.4.1)

SIZES = {0x0: "<q", 0x2: "<H", 0x3: "<I", 0x4: "<Q", 0x8: "<q", 0xA: "<h", 0xB: "<i", 0xC: "<q"}
RELATIVE = 0x10


def _unwound(section: Section) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each function that .eh_frame has."""
    data, at = bytes(section.data), 0
    encodings: dict[int, int] = {}
    while at + 8 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        body = at + 4
        if length == 0xFFFFFFFF:
            (length,) = struct.unpack_from("<Q", data, body)
            body += 8
        if length == 0:  # the end of what one object file brought
            at = body
            continue
        (common,) = struct.unpack_from("<I", data, body)
        if common == 0:
            encodings[at] = _encoding(data[body + 4 : body + length])
        else:
            encoding = encodings.get(body - common, 0xFF)
            form = SIZES.get(encoding & 0x0F)
            if form and encoding & 0x70 in (0, RELATIVE):
                place = body + 4
                (begin,) = struct.unpack_from(form, data, place)
                (size,) = struct.unpack_from(form, data, place + struct.calcsize(form))
                if encoding & 0x70 == RELATIVE:
                    begin += section.address + place
                yield begin, begin + size
        at = body + length


def _encoding(body: bytes) -> int:
    """How the entries of a common one write their addresses; 0xFF where this is not understood."""
    end = body.index(b"\0", 1)
    augmentation, at = body[1:end], end + 1
    if not augmentation.startswith(b"z"):
        return 0x00 if not augmentation else 0xFF
    for _ in range(2):  # alignments of code and data
        at = _after_number(body, at)
    at = at + 1 if body[0] == 1 else _after_number(body, at)  # the register of the return address
    at = _after_number(body, at)
    for letter in augmentation[1:].decode("latin-1"):
        if letter == "R":
            return body[at]
        if letter == "L":
            at += 1
        elif letter == "P":
            at += 1 + struct.calcsize(SIZES[body[at] & 0x0F])
    return 0x00


def _after_number(body: bytes, at: int) -> int:
    """Return what follows a number of variable length."""
    while body[at] & 0x80:
        at += 1
    return at + 1
