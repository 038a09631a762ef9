"""Instructions of AArch64 that the processor of a Raspberry Pi 4 lacks, by their encodings.

A Cortex-A72 is ARMv8.0-A with the CRC32 instructions and, as Broadcom made it, without the
cryptographic ones. The encodings are those of the Arm Architecture Reference Manual for A-profile
(DDI 0487), chapter C4 "A64 Instruction Set Encoding"; each row is (mask, value): a word belongs to
the class when ``word & mask == value``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.uint32]

CLASSES: dict[str, tuple[tuple[int, int], ...]] = {
    # Cryptographic AES, two and three register SHA, PMULL of 64 bits (C4.1.96).
    "aes": ((0xFFFFCC00, 0x4E284800),),
    "pmull": ((0xBFE0FC00, 0x0EE0E000),),
    "sha1": ((0xFFE0CC00, 0x5E000000), (0xFFFFEC00, 0x5E280800)),
    "sha2": ((0xFFE0CC00, 0x5E004000), (0xFFFFFC00, 0x5E282800)),
    # Cryptographic four register, three register imm2 and SHA512 (ARMv8.2).
    "sha3": ((0xFFC08000, 0xCE000000), (0xFFE00000, 0xCE800000), (0xFFFFFC00, 0xCEC08000),
             (0xFFE0F000, 0xCE608000)),
    "sm": ((0xFFE08000, 0xCE400000), (0xFFE0C000, 0xCE408000), (0xFFE0F800, 0xCE60C000),
           (0xFFE0FC00, 0xCE60C800), (0xFFFFFC00, 0xCEC08400)),
    # Atomic memory operations, compare and swap (ARMv8.1).
    "lse": ((0x3F20FC00, 0x38200000), (0x3F20FC00, 0x38201000), (0x3F20FC00, 0x38202000),
            (0x3F20FC00, 0x38203000), (0x3F20FC00, 0x38204000), (0x3F20FC00, 0x38205000),
            (0x3F20FC00, 0x38206000), (0x3F20FC00, 0x38207000), (0x3F20FC00, 0x38208000),
            (0x3FA07C00, 0x08A07C00), (0xBFA07C00, 0x08207C00)),
    "lor": ((0x3FFFFC00, 0x08DF7C00), (0x3FFFFC00, 0x089F7C00)),
    # Load-acquire of RCpc (ARMv8.3 and 8.4), copies of memory (8.8).
    "rcpc": ((0x3FFFFC00, 0x38BFC000), (0x3F200C00, 0x19000000)),
    "mops": ((0x3B200C00, 0x19000400),),
    # SQRDMLAH and SQRDMLSH (ARMv8.1).
    "rdm": ((0xBF20F400, 0x2E008400), (0xFF20F400, 0x7E008400), (0xBF00D400, 0x2F00D000),
            (0xFF00D400, 0x7F00D000)),
    # SDOT and UDOT (ARMv8.2), matrices of bytes and of bfloat16 (8.6).
    "dotprod": ((0x9FE0FC00, 0x0E809400), (0x9FC0F400, 0x0F80E000)),
    "i8mm": ((0xBFE0FC00, 0x0E809C00), (0xDFE0FC00, 0x4E80A400), (0xFFE0FC00, 0x4E80AC00),
             (0xBFC0F400, 0x0F80F000), (0xBFC0F400, 0x0F00F000)),
    "bf16": ((0xBFE0FC00, 0x2E40FC00), (0xFFE0FC00, 0x6E40EC00), (0xBFE0FC00, 0x2EC0FC00),
             (0xBFFFFC00, 0x0EA16800), (0xFFFFFC00, 0x1E634000), (0xBFC0F400, 0x0F40F000),
             (0xBFC0F400, 0x0FC0F000)),
    # Arithmetic of half precision (ARMv8.2); its conversions are of ARMv8.0 and not here.
    "fp16": ((0xFFE00C00, 0x1EE00800), (0xFFE0FC07, 0x1EE02000), (0xFFE00C00, 0x1EE00400),
             (0xFFE00C00, 0x1EE00C00), (0xFFE01FE0, 0x1EE01000), (0xFFC00000, 0x1FC00000),
             (0x7FE0FC00, 0x1EE00000), (0x7FE00000, 0x1EC00000), (0xFFFE7C00, 0x1EE04000),
             (0xFFFC7C00, 0x1EE44000), (0x9F60C400, 0x0E400400),
             (0xDF60C400, 0x5E400400), (0x9F7E0C00, 0x0E780800), (0xDF7E0C00, 0x5E780800),
             (0xBF7FCC00, 0x0E30C800), (0xBFF8FC00, 0x0F00FC00), (0xBFC0F400, 0x0F001000),
             (0xBFC0F400, 0x0F005000), (0x9FC0F400, 0x0F009000), (0xFFC0F400, 0x5F001000),
             (0xFFC0F400, 0x5F005000), (0xDFC0F400, 0x5F009000), (0xBFE0FC00, 0x0E20EC00),
             (0xBFE0FC00, 0x0EA0EC00), (0xBFE0FC00, 0x2E20CC00), (0xBFE0FC00, 0x2EA0CC00),
             (0xBFC0B400, 0x0F800000), (0xBFC0B400, 0x2F808000)),
    # Complex numbers and JavaScript's conversion (ARMv8.3), flags (8.4).
    "fcma": ((0xBF20E400, 0x2E00C400), (0xBF20EC00, 0x2E00E400), (0xBFC09400, 0x2F401000),
             (0xBFC09400, 0x2F801000), (0xFFFFFC00, 0x1E7E0000)),
    "flagm": ((0xFFFFFFFF, 0xD500401F), (0xFFE07C10, 0xBA000400), (0xFFFFBC1F, 0x3A00080D)),
    # Signed pointers (ARMv8.3), but those in the space of hints, which a Pi 4 passes over.
    "pauth": ((0xFFFF0000, 0xDAC10000), (0xFFE0FC00, 0x9AC03000), (0xFFFFFBFF, 0xD65F0BFF),
              (0xFEDFF800, 0xD61F0800), (0xFF200400, 0xF8200400)),
    "mte": ((0xFF200400, 0xD9200400), (0xFF200C00, 0xD9200800), (0xFFE0FC00, 0x9AC01000),
            (0xFFE00C00, 0xD9600000), (0xBFC0C000, 0x91800000)),
    # Scalable vectors: a quarter of the space of encodings is theirs.
    "sve": ((0x1E000000, 0x04000000),),
    "sme": ((0x9E000000, 0x80000000),),
}  # fmt: skip

RET = 0xD65F03C0
# In the place of the unwinder of GCC's own library: only for a frame that has scalable registers.
CNTD_X0 = 0x04E0E3E0
CHUNK = 1 << 20
TEXT = 4


def _heads() -> npt.NDArray[np.bool_]:
    """Which upper halves of words the encodings above can have: most words have none of them."""
    halves = np.arange(1 << 16, dtype=np.uint32)
    found = np.zeros(1 << 16, dtype=bool)
    for mask, value in (row for rows in CLASSES.values() for row in rows):
        found |= (halves & np.uint32(mask >> 16)) == np.uint32(value >> 16)
    return found


HEADS = _heads()


def find(words: Words) -> dict[str, npt.NDArray[np.int64]]:
    """Places of the words of each class; a class that does not occur is left out."""
    found: dict[str, list[npt.NDArray[np.int64]]] = {}
    for start in range(0, len(words), CHUNK):
        part = words[start : start + CHUNK]
        candidates = np.flatnonzero(HEADS[part >> np.uint32(16)])
        left = part[candidates]
        for name, rows in CLASSES.items():
            hit = np.zeros(len(left), dtype=bool)
            for mask, value in rows:
                hit |= (left & np.uint32(mask)) == np.uint32(value)
            if hit.any():
                found.setdefault(name, []).append(candidates[hit] + start)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def is_text(words: Words) -> npt.NDArray[np.bool_]:
    """Which words are of a text of 16 printable characters or more: between functions, a name.

    One word alone may be printable and an instruction: ``aese v0.16b, v1.16b`` is " H(N".
    """
    quads = np.ascontiguousarray(words, "<u4").view(np.uint8).reshape(-1, 4)
    printable = ((quads >= 0x20) & (quads < 0x7F)).all(axis=1)
    edges = np.flatnonzero(np.diff(printable, prepend=False, append=False))
    found = np.zeros(len(words), dtype=bool)
    for begin, end in edges.reshape(-1, 2)[np.diff(edges)[::2] >= TEXT]:
        found[begin:end] = True
    return found


def outlined(words: Words, places: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Which atomic instructions are those of the helpers that compilers call in their place.

    The helper of GCC and LLVM asks ``__aarch64_have_lse_atomics`` first, which the C library's
    HWCAP_ATOMICS sets: ``ldrb w16, [x16, ...]; cbz w16, other; ldadd ...; ret``.
    """
    before = words[np.maximum(places - 1, 0)]
    asked = (before & np.uint32(0xFF00001F)) == np.uint32(0x34000010)
    after = words[np.minimum(places + 1, len(words) - 1)]
    # A CAS moves its result before it returns.
    moved = words[np.minimum(places + 2, len(words) - 1)]
    moves = (after & np.uint32(0x7FE0FFE0)) == np.uint32(0x2A0003E0)
    return asked & ((after == np.uint32(RET)) | (moves & (moved == np.uint32(RET))))
