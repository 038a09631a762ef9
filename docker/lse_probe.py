"""Execute one LSE instruction (ldadd, ARMv8.1) and say whether this CPU takes it.

A Cortex-A72 (Raspberry Pi 4) has none and must answer with SIGILL. The control of the emulated
tests: where this says "refused", a wheel that needs LSE dies as it would on the Pi.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import platform
import signal
import struct
import sys

LDADD_W1_W0_X0 = 0xB8210000  # w0 = [x0]; [x0] += w1      (Arm Architecture Reference Manual, C6)
RET = 0xD65F03C0


def execute() -> int:
    """Add 2 to 40 by the instruction; return what is then in memory."""
    descriptor = os.memfd_create("lse")  # a file, so that the kernel keeps the caches coherent
    os.write(descriptor, struct.pack("<II", LDADD_W1_W0_X0, RET).ljust(mmap.PAGESIZE, b"\0"))
    code = mmap.mmap(
        descriptor,
        mmap.PAGESIZE,
        mmap.MAP_PRIVATE,
        mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC,
    )
    function = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)(
        ctypes.addressof(ctypes.c_char.from_buffer(code))
    )
    number = ctypes.c_uint32(40)
    old = function(ctypes.addressof(number), 2)
    return number.value if old == 40 else -1


def main() -> int:
    if platform.machine() != "aarch64":
        print("no arm64")
        return 2
    child = os.fork()
    if child == 0:
        os._exit(0 if execute() == 42 else 1)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGILL:
        print("refused")
        return 0
    print("executes" if status == 0 else f"unclear: status {status}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
