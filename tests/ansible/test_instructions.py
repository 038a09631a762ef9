"""The scan of wheels for instructions that a Raspberry Pi 4 lacks.

The encodings are held against words of the Arm Architecture Reference Manual, against binutils
where it is installed, and against qemu's Cortex-A72, which must refuse what the docs say it does.
"""

from __future__ import annotations

import json
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import a64
import control
import elf
import instruction_probe
import instructions
import numpy as np
import pytest

from qrobot.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
# DDI 0487, C6.2 and C7.2: an instruction, its word, and the kind it is of (none: a Pi 4 has it).
WORDS = [
    ("aese v0.16b, v1.16b", 0x4E284820, "aes"), ("aesimc v31.16b, v30.16b", 0x4E287BDF, "aes"),
    ("pmull v0.1q, v1.1d, v2.1d", 0x0EE2E020, "pmull"),
    ("pmull2 v0.1q, v1.2d, v2.2d", 0x4EE2E020, "pmull"),
    ("pmull v0.8h, v1.8b, v2.8b", 0x0E22E020, ""), ("pmul v0.8b, v1.8b, v2.8b", 0x2E229C20, ""),
    ("sha1c q0, s1, v2.4s", 0x5E020020, "sha1"), ("sha1su1 v0.4s, v1.4s", 0x5E281820, "sha1"),
    ("sha256h2 q0, q1, v2.4s", 0x5E025020, "sha2"), ("sha256su0 v0.4s, v1.4s", 0x5E282820, "sha2"),
    ("sha512h q0, q1, v2.2d", 0xCE628020, "sha3"),
    ("eor3 v0.16b, v1.16b, v2.16b, v3.16b", 0xCE020C20, "sha3"),
    ("sm4e v0.4s, v1.4s", 0xCEC08420, "sm"), ("sm3partw1 v0.4s, v1.4s, v2.4s", 0xCE62C020, "sm"),
    ("ldadd w1, w0, [x0]", 0xB8210000, "lse"), ("swpal x1, x2, [x3]", 0xF8E18062, "lse"),
    ("stclrb w1, [x2]", 0x3821105F, "lse"), ("cas w1, w2, [x0]", 0x88A17C02, "lse"),
    ("caspal x0, x1, x2, x3, [x4]", 0x4860FC82, "lse"),
    ("ldaxr w0, [x1]", 0x885FFC20, ""), ("stlxr w0, w1, [x2]", 0x8800FC41, ""),
    ("ldxp x0, x1, [x2]", 0xC87F0440, ""), ("ldar w0, [x1]", 0x88DFFC20, ""),
    ("ldr x0, [x1, x2]", 0xF8626820, ""), ("ldr x0, [x1], #8", 0xF8408420, ""),
    ("ldlar w0, [x0]", 0x88DF7C00, "lor"), ("ldapr w0, [x0]", 0xB8BFC000, "rcpc"),
    ("ldapur x0, [x1, #8]", 0xD9408020, "rcpc"), ("cpyfp [x3]!, [x4]!, x5!", 0x190404A3, "mops"),
    ("sqrdmlah v0.4s, v1.4s, v2.4s", 0x6E828420, "rdm"),
    ("sqrdmulh v0.4s, v1.4s, v2.4s", 0x6EA2B420, ""),
    ("udot v0.4s, v1.16b, v2.16b", 0x6E829420, "dotprod"),
    ("sdot v0.4s, v1.16b, v2.4b[1]", 0x4FA2E020, "dotprod"),
    ("smmla v0.4s, v1.16b, v2.16b", 0x4E82A420, "i8mm"),
    ("bfdot v0.4s, v1.8h, v2.8h", 0x6E42FC20, "bf16"),
    ("bfcvt h0, s1", 0x1E634020, "bf16"),
    ("fcvt h0, s1", 0x1E23C020, ""), ("fcvt s0, h1", 0x1EE24020, ""),
    ("fcvt d0, h1", 0x1EE2C020, ""), ("fcvtl v0.4s, v1.4h", 0x0E217820, ""),
    ("fadd h0, h1, h2", 0x1EE22820, "fp16"), ("fmov h0, #1.0", 0x1EEE1000, "fp16"),
    ("fmov w0, h1", 0x1EE60020, "fp16"), ("fcmp h0, #0.0", 0x1EE02008, "fp16"),
    ("fmadd h0, h1, h2, h3", 0x1FC20C20, "fp16"), ("fadd v0.8h, v1.8h, v2.8h", 0x4E421420, "fp16"),
    ("fmla v0.8h, v1.8h, v2.h[3]", 0x4F321020, "fp16"),
    ("fmlal v0.4s, v1.4h, v2.4h", 0x4E22EC20, "fp16"),
    ("fsqrt h0, h1", 0x1EE1C020, "fp16"), ("frintn v0.4h, v1.4h", 0x0E798820, "fp16"),
    ("fadd s0, s1, s2", 0x1E222820, ""), ("fadd v0.4s, v1.4s, v2.4s", 0x4E22D420, ""),
    ("fmla v0.4s, v1.4s, v2.s[1]", 0x4FA21020, ""), ("fmov s0, #1.0", 0x1E2E1000, ""),
    ("add v0.8h, v1.8h, v2.8h", 0x4E628420, ""), ("mla v0.8h, v1.8h, v2.h[3]", 0x6F720020, ""),
    ("fcadd v0.4s, v1.4s, v2.4s, #90", 0x6E82E420, "fcma"), ("fjcvtzs w0, d0", 0x1E7E0000, "fcma"),
    ("cfinv", 0xD500401F, "flagm"),
    ("pacia x3, x4", 0xDAC10083, "pauth"), ("retaa", 0xD65F0BFF, "pauth"),
    ("paciasp", 0xD503233F, ""),
    ("bti c", 0xD503245F, ""), ("ret", 0xD65F03C0, ""), ("nop", 0xD503201F, ""),
    ("stg x0, [x1]", 0xD9200820, "mte"), ("ptrue p0.b", 0x2518E3E0, "sve"),
    ("crc32w w0, w1, w2", 0x1AC24820, ""), ("mul x0, x1, x2", 0x9B027C20, ""),
    ("ld1 {v0.16b}, [x0]", 0x4C407000, ""), ("tbl v0.16b, {v1.16b}, v2.16b", 0x4E020020, ""),
]  # fmt: skip
TOOLS = "aarch64-linux-gnu-"
needs_binutils = pytest.mark.skipif(
    shutil.which(f"{TOOLS}as") is None, reason="not here (Debian: binutils-aarch64-linux-gnu)"
)


def kinds_of(word: int) -> list[str]:
    return list(a64.find(np.array([word], dtype=np.uint32)))


@pytest.mark.parametrize(("text", "word", "kind"), WORDS, ids=[row[0] for row in WORDS])
def test_an_instruction_is_of_its_kind(text: str, word: int, kind: str) -> None:
    assert kinds_of(word) == ([kind] if kind else [])


@needs_binutils
def test_the_words_are_what_an_assembler_makes_of_them(tmp_path: Path) -> None:
    code = ".arch armv9-a+crypto+sha3+sm4+fp16fml+bf16+i8mm+mops+flagm+memtag\n"
    code += "".join(f"{text}\n" for text, *_ in WORDS)
    (tmp_path / "a.s").write_text(code)
    subprocess.run(
        [f"{TOOLS}as", "a.s", "-o", "a.o"], cwd=tmp_path, check=True, capture_output=True
    )
    (part,) = elf.code((tmp_path / "a.o").read_bytes())
    assert [hex(word) for word in part.words] == [hex(word) for _, word, _ in WORDS]
    assert part.sure.all()  # by its mapping symbol


MNEMONICS = {
    "aes": r"aes", "pmull": r"pmull", "sha1": r"sha1", "sha2": r"sha256", "sm": r"sm[34]",
    "sha3": r"sha512|eor3|bcax|xar|rax1", "lor": r"ldlar|stllr", "rcpc": r"ldap|stlur",
    "lse": r"(ld|st)(add|clr|eor|set|[su]max|[su]min)|cas|swp", "mops": r"cpy|set",
    "rdm": r"sqrdml",
    "dotprod": r"[su]dot", "i8mm": r"usdot|sudot|u?s?u?mmla", "bf16": r"bf",
    "fcma": r"fcmla|fcadd|fjcvt",
    "flagm": r"cfinv|rmif|setf", "pauth": r"pac|aut|xpac|ret|br|blr|ldra",
    "mte": r"st2?z?2?g|ldg|irg|addg|subg",
    "fp16": r"f|[su]cvtf",
}  # fmt: skip


MISSED = re.compile(
    r"aes\w+|sha(1|256|512)\w+|sm[34]\w+|eor3|bcax|xar|rax1|casp?a?l?[bh]?|swpa?l?[bh]?"
    r"|(ld|st)(add|clr|eor|set|[su]max|[su]min)a?l?[bh]?|sqrdml\w+|[su]dot|usdot|sudot|u?s?mmla"
    r"|bf(dot|mmla|mlal[bt]|cvtn?2?)|fcmla|fcadd|fjcvtzs|cfinv|rmif|setf\d+|pac[id]?z?[ab]|ldapu?r\w*"
)
ARITHMETIC = re.compile(r"f(add|sub|mul|div|sqrt|max|min|n?madd|n?msub|cmp|mla|mls)")


@needs_binutils
def test_a_disassembler_calls_them_the_same(tmp_path: Path) -> None:
    """Words at random: of each encoding, and of all others."""
    random = np.random.default_rng(12)
    parts = [random.integers(0, 1 << 32, 60_000, dtype=np.uint64)]
    for rows in a64.CLASSES.values():
        for mask, value in rows:
            free = random.integers(0, 1 << 32, 150, dtype=np.uint64) & np.uint64(~mask & 0xFFFFFFFF)
            parts.append(free | np.uint64(value))
    words = np.concatenate(parts).astype("<u4")
    (tmp_path / "words").write_bytes(words.tobytes())
    told = subprocess.run(
        [f"{TOOLS}objdump", "--disassemble-all", "-b", "binary", "-m", "aarch64", "words"],
        capture_output=True, text=True, check=True, cwd=tmp_path,
    ).stdout  # fmt: skip
    lines = re.findall(r"^\s*([0-9a-f]+):\s+[0-9a-f]{8}\s+(\S+)(.*)$", told, re.MULTILINE)
    names = {int(place, 16) // 4: (name, rest) for place, name, rest in lines}
    found = {int(place): kind for kind, places in a64.find(words).items() for place in places}
    assert set(found.values()) == set(a64.CLASSES)
    for place, (name, rest) in names.items():
        kind = found.get(place, "")
        if name in (".inst", "udf") or kind in ("sve", "sme"):
            continue  # a word that is no instruction yet; a space that is theirs as a whole
        if kind:
            assert re.match(MNEMONICS[kind], name), (hex(words[place]), name, kind)
        else:
            assert not MISSED.fullmatch(name), (hex(words[place]), name)
            assert not (name.startswith("pmull") and ".1q" in rest)
            assert not (ARITHMETIC.match(name) and re.search(r"\bh\d|\.[48]h\b", rest))


# Programs


def program(words: list[int], symbols: bool = False) -> bytes:
    """Make a program for qemu and for the scan: one segment, one section, no libraries."""
    code = struct.pack(f"<{len(words)}I", *words)
    base, start = 0x400000, 0x1000
    names = b"\0.text\0.shstrtab\0"
    sections_at = start + len(code) + len(names)
    head = b"\x7fELF\x02\x01\x01".ljust(16, b"\0")
    head += struct.pack(
        "<HHIQQQIHHHHHH", 2, 183, 1, base + start, 64, sections_at, 0, 64, 56, 1, 64, 3, 2
    )
    head += struct.pack("<IIQQQQQQ", 1, 7, 0, base, base, sections_at, sections_at, 0x1000)
    text = struct.pack("<IIQQQQIIQQ", 1, 1, 6, base + start, start, len(code), 0, 0, 4, 0)
    strings = struct.pack("<IIQQQQIIQQ", 7, 3, 0, 0, start + len(code), len(names), 0, 0, 1, 0)
    return head.ljust(start, b"\0") + code + names + bytes(64) + text + strings


ADR_X0, EXIT = 0x10000100, [0xD2800000, 0xD2800BA8, 0xD4000001]  # adr x0, .+32; exit(0)


def runs(word: int, cpu: str, folder: Path) -> str:
    """What becomes of a program with this word on an emulated processor."""
    emulator = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")
    if emulator is None:
        pytest.skip("no qemu-user here (Debian: qemu-user-static)")
    path = folder / "program"
    path.write_bytes(program([ADR_X0, word, *EXIT, 0, 0, 0, 0, 0, 0, 0]))
    path.chmod(0o755)
    done = subprocess.run([emulator, "-cpu", cpu, path], capture_output=True, check=False)
    return {0: "executed", -4: "refused"}.get(done.returncode, f"unclear, {done.returncode}")


def test_the_emulated_processor_refuses_what_the_docs_say(tmp_path: Path) -> None:
    """All that a Pi 4 lacks, but the cryptographic instructions."""
    kinds = instruction_probe.KINDS
    cpu = {name: runs(word, "cortex-a72", tmp_path) for name, word in kinds.items()}
    largest = {name: runs(word, "max", tmp_path) for name, word in kinds.items()}
    assert {name for name, said in cpu.items() if said != "refused"} == set(
        instruction_probe.NOT_REFUSED
    )
    assert set(largest.values()) == {"executed"}
    told, wrong = control.judge(cpu, largest)
    assert wrong == ""
    assert "executed, though a Pi 4 refuses it, so not proven here: aes, pmull, sha1, sha2" in told
    page = (ROOT / "docs/images.md").read_text()
    for kind in instruction_probe.NOT_REFUSED:
        assert re.search(rf"\b{kind.upper().replace('SHA', 'SHA-')}\b", page), kind


def test_the_probe_asks_for_each_kind_that_is_scanned_for() -> None:
    for name, word in instruction_probe.KINDS.items():
        assert kinds_of(word) == [name]
    # What no release of qemu here runs, or has no word of its own.
    assert set(a64.CLASSES) - set(instruction_probe.KINDS) == {"mops", "mte", "sme"}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"lse": "executed"}, "the emulator executes lse"),
        ({"aes": "unclear, status 139"}, "the control is unclear: aes"),
    ],
)
def test_a_control_that_proves_too_little_fails(
    change: dict[str, str], says: str, tmp_path: Path, capsys: Any, monkeypatch: Any
) -> None:
    good = {name: "executed" if name in instruction_probe.NOT_REFUSED else "refused"
            for name in instruction_probe.KINDS}  # fmt: skip
    largest = dict.fromkeys(good, "executed")
    assert control.judge(good, largest)[1] == ""
    assert "refuses sve too" in control.judge(good, largest | {"sve": "refused"})[1]
    assert says in control.judge(good | change, largest)[1]
    for name, said in (("cpu", good | change), ("max", largest)):
        (tmp_path / name).write_text(json.dumps(said))
    monkeypatch.setattr(sys, "argv", ["control.py", str(tmp_path / "cpu"), str(tmp_path / "max")])
    assert control.main() == 1
    assert says in capsys.readouterr().err


# Wheels

HELPER = [0x90000010, 0x39400210, 0x34000070, 0xB8E00020, 0xD65F03C0]
"""``__aarch64_ldadd4_acq_rel`` of GCC: adrp x16; ldrb w16, [x16]; cbz w16, other; ldaddal; ret."""


def wheel(folder: Path, name: str, **files: bytes) -> Path:
    path = folder / f"{name}-1.0-py3-none-manylinux2014_aarch64.whl"
    with zipfile.ZipFile(path, "w") as made:
        for file, content in files.items():
            made.writestr(f"{name}/{file}.so", content)
    return path


def found_in(path: Path) -> dict[str, tuple[int, int]]:
    return {one.kind: (one.sure, one.possible) for one in instructions.scan_wheel(path)}


def test_a_helper_that_asks_first_needs_no_review(tmp_path: Path) -> None:
    assert found_in(wheel(tmp_path, "a", b=program(HELPER))) == {}
    unasked = [HELPER[3] if word == HELPER[2] else word for word in HELPER]
    assert found_in(wheel(tmp_path, "a", b=program(unasked))) == {"lse": (0, 2)}
    assert found_in(wheel(tmp_path, "a", b=program([*HELPER, 0xB8E00020]))) == {"lse": (0, 1)}


def test_a_text_between_functions_is_no_instruction(tmp_path: Path) -> None:
    text = b"  AES for ARMv8, CRYPTOGAMS by ."
    words = list(struct.unpack(f"<{len(text) // 4}I", text))
    assert kinds_of(words[4]) == ["rcpc"]
    assert found_in(wheel(tmp_path, "a", b=program(words))) == {}


@needs_binutils
@pytest.mark.parametrize("stripped", [False, True])
def test_code_is_told_from_data_by_the_tables_of_the_file(tmp_path: Path, stripped: bool) -> None:
    (tmp_path / "a.s").write_text(
        ".arch armv8.2-a+dotprod+crypto\n.text\n.globl f\n.type f,%function\nf:\n.cfi_startproc\n"
        "udot v0.4s, v1.16b, v2.16b\nret\n.cfi_endproc\n.size f, .-f\n"
        ".word 0x4e284820\nhidden:\nsha1h s0, s1\nret\n"
    )
    subprocess.run([f"{TOOLS}as", "a.s", "-o", "a.o"], cwd=tmp_path, check=True)
    subprocess.run([f"{TOOLS}ld", "-shared", "a.o", "-o", "a.so"], cwd=tmp_path, check=True)
    if stripped:
        subprocess.run([f"{TOOLS}strip", "a.so"], cwd=tmp_path, check=True)
    path = wheel(tmp_path, "a", b=(tmp_path / "a.so").read_bytes())
    # Without its symbols the file tells of f only, by its table for unwinding.
    want = {"dotprod": (1, 0), "aes": (0, 1), "sha1": (0, 1) if stripped else (1, 0)}
    assert found_in(path) == want


def test_other_machines_and_cut_files(tmp_path: Path) -> None:
    good = program([0xB8210000])
    foreign = bytearray(good)
    foreign[18] = 62  # x86-64
    path = wheel(tmp_path, "a", x=bytes(foreign), empty=b"", text=b"# no program", magic=b"\x7fELF")
    assert found_in(path) == {}
    bad = bytearray(good)
    bad[0x28:0x30] = (1 << 40).to_bytes(8, "little")  # sections far behind the end
    assert found_in(wheel(tmp_path, "a", bad=bytes(bad))) == {"unreadable": (0, 0)}
    with pytest.raises(InputError, match="not a wheel"):
        instructions.scan_wheel(ROOT / "README.md")
    (tmp_path / "cut-1.0-py3-none-any.whl").write_bytes(b"PK")
    with pytest.raises(InputError, match="not a wheel"):
        instructions.scan_wheel(tmp_path / "cut-1.0-py3-none-any.whl")


def test_what_nobody_has_reviewed_is_told_and_fails(tmp_path: Path, capsys: Any) -> None:
    path = wheel(tmp_path, "thing", core=program([0x4E284820, 0xB8210000]))
    found = instructions.scan([path], tmp_path / "cache.json")
    known = [instructions.Review("thing", ("aes",), "asks getauxval", "thing/core*")]
    (sentence,) = instructions.unreviewed(found, known)
    assert sentence.startswith("thing: thing/core.so: perhaps lse, the first at 0x401004; a Pi 4")
    assert "instructions.toml" in sentence
    for other in (
        instructions.Review("other", ("aes",), "r"),
        instructions.Review("thing", ("aes",), "r", "thing/other*"),
    ):
        assert len(instructions.unreviewed(found, [other])) == 2
    # It is remembered by the hash of the wheel, and forgotten when the scan learns something.
    cached = json.loads((tmp_path / "cache.json").read_text())
    assert len(cached["wheels"]) == 1
    (tmp_path / "cache.json").write_text(json.dumps(cached | {"scanner": -1, "wheels": {}}))
    assert instructions.scan([path], tmp_path / "cache.json") == found
    command = [sys.executable, str(ROOT / "ansible/controller/instructions.py"), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert "NOT REVIEWED" in done.stdout
    assert "2 findings are not reviewed" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_reviews_are_whole_and_the_docs_have_them() -> None:
    known = instructions.reviews()
    page = (ROOT / "docs/images.md").read_text()
    for one in known:
        rows = [line for line in page.splitlines() if line.startswith(f"| `{one.package}`")]
        assert any(all(kind in row for kind in one.kinds) for row in rows), one
    locked = (ROOT / "locks/full.txt").read_text() + (ROOT / "locks/provision.txt").read_text()
    for one in known:
        assert re.search(rf"^{re.escape(one.package)}==", locked, re.MULTILINE), one.package


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("safe = 1", "cannot be used"),
        ('[[safe]]\npackage = "a"', "cannot be used"),
        ('[[safe]]\npackage = "a"\nkinds = ["lsd"]\nreason = "r"', "'lsd'|lsd is not a kind"),
        ('[[safe]]\npackage = "a"\nkinds = ["lse"]\nreason = " "', "a reason is missing"),
        ("[[safe", "cannot be used"),
    ],
)
def test_a_review_that_cannot_be_used_is_one_sentence(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "reviews.toml").write_text(text)
    with pytest.raises(InputError, match=says):
        instructions.reviews(tmp_path / "reviews.toml")
