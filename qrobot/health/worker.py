"""The process of one check: ``python -m qrobot.health.worker MODULE PIPE``.

Only ever started by `runner.run`. It writes lines of JSON to the pipe as it gets on, so that
the runner knows how far a process came that is no more.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import resource
import signal
import sys
import time
from pathlib import Path
from typing import Any

__all__ = ["main"]

PR_SET_PDEATHSIG = 1
"""From linux/prctl.h."""


def main() -> None:
    """Import the stack, compute, and tell both."""
    module, pipe = sys.argv[1], int(sys.argv[2])

    def tell(**data: Any) -> None:
        os.write(pipe, json.dumps(data).encode() + b"\n")

    _behave()
    try:
        check = importlib.import_module(module).CHECK
        begun = time.perf_counter()
        for name in check.imports:
            importlib.import_module(name)
        tell(import_seconds=time.perf_counter() - begun)
        begun = time.perf_counter()
        answer = [float(number) for number in check.answer()]
        tell(run_seconds=time.perf_counter() - begun, answer=answer, peak_mb=_peak())
        tell(expected=[float(number) for number in check.expected()])
    except MemoryError:
        tell(error="out of memory")
    except Exception as error:
        text = " ".join(str(error).split())
        tell(error=f"{type(error).__name__}: {text}"[:2000])


def _behave() -> None:
    """Leave no core dump, die with the runner, and be the first that a full machine kills."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        try:
            Path("/proc/self/oom_score_adj").write_text("1000")
        except OSError:
            return  # some containers forbid it; the kernel then chooses by size


def _peak() -> float:
    """Return the largest resident memory of this program in MiB.

    `getrusage` would do, but on Linux it starts at the size of who started us.
    """
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
