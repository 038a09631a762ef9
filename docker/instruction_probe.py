"""Execute one instruction of each kind that a Raspberry Pi 4 lacks, and say which this CPU takes.

The control of the emulated tests: each kind that is "refused" here dies by SIGILL as it would on a
Pi. qemu's Cortex-A72 has the cryptographic instructions, which Broadcom left out of the Pi's: those
are "executed", so no emulated test proves that a wheel does without them. The scan of the wheels
(ansible/controller/instructions.py) looks for these.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import os
import platform
import signal
import struct
import sys

# Arm Architecture Reference Manual for A-profile (DDI 0487), C6 and C7. x0 leads to eight bytes.
KINDS = {
    "lse": 0xB8210000,  # ldadd w1, w0, [x0]
    "lor": 0x88DF7C00,  # ldlar w0, [x0]
    "rcpc": 0xB8BFC000,  # ldapr w0, [x0]
    "rdm": 0x6E828420,  # sqrdmlah v0.4s, v1.4s, v2.4s
    "dotprod": 0x6E829420,  # udot v0.4s, v1.16b, v2.16b
    "fp16": 0x1EE22820,  # fadd h0, h1, h2
    "i8mm": 0x4E82A420,  # smmla v0.4s, v1.16b, v2.16b
    "bf16": 0x6E42FC20,  # bfdot v0.4s, v1.8h, v2.8h
    "fcma": 0x6E82E420,  # fcadd v0.4s, v1.4s, v2.4s, #90
    "flagm": 0xD500401F,  # cfinv
    "pauth": 0xDAC10083,  # pacia x3, x4
    "sve": 0x04E0E3E3,  # cntd x3
    "sha3": 0xCE020C20,  # eor3 v0.16b, v1.16b, v2.16b, v3.16b
    "sm": 0xCEC08420,  # sm4e v0.4s, v1.4s
    "aes": 0x4E284820,  # aese v0.16b, v1.16b
    "pmull": 0x0EE2E020,  # pmull v0.1q, v1.1d, v2.1d
    "sha1": 0x5E280820,  # sha1h s0, s1
    "sha2": 0x5E024020,  # sha256h q0, q1, v2.4s
}
NOT_REFUSED = ("aes", "pmull", "sha1", "sha2")
"""What qemu's Cortex-A72 executes and a Pi 4 does not."""
RET = 0xD65F03C0


def execute(word: int) -> None:
    """Run one instruction, and return."""
    descriptor = os.memfd_create("probe")  # a file, so that the kernel keeps the caches coherent
    os.write(descriptor, struct.pack("<II", word, RET).ljust(mmap.PAGESIZE, b"\0"))
    code = mmap.mmap(
        descriptor,
        mmap.PAGESIZE,
        mmap.MAP_PRIVATE,
        mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC,
    )
    function = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)(
        ctypes.addressof(ctypes.c_char.from_buffer(code))
    )
    function(ctypes.addressof((ctypes.c_uint64 * 2)()), 2)


def probe(word: int) -> str:
    """Say what becomes of a process that executes a word."""
    child = os.fork()
    if child == 0:
        execute(word)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGILL:
        return "refused"
    return "executed" if status == 0 else f"unclear, status {status}"


def main() -> int:
    if platform.machine() != "aarch64":
        print("not an arm64 machine", file=sys.stderr)
        return 2
    print(json.dumps({name: probe(word) for name, word in KINDS.items()}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
