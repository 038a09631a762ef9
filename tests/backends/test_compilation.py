"""`qrobot compile` leaves nothing to be compiled by a plan."""

from __future__ import annotations

import subprocess
import sys

import pytest

from qrobot import _jit

pytest.importorskip("ortools")

SCRIPT = """
import sys
from qrobot.backends import Stop, get
from qrobot.backends.classical.compilation import compile_searches
from qrobot.problem.formats import read

def compiled():
    found = {}
    for module in [m for name, m in sys.modules.items() if name.startswith("qrobot.")]:
        for name, kernel in vars(module).items():
            # Only those that Python calls are kept on disk; others are parts of them.
            if hasattr(kernel, "stats") and kernel.stats.cache_path:
                found[f"{kernel.py_func.__module__}.{name}"] = set(kernel.signatures)
    return found

compile_searches()
before = compiled()
instance = read("example:small-warehouse")
for backend in ("batching", "exact", "savings"):
    get(backend).search(instance, stop=Stop(max_work=3), seed=1)
after = compiled()
print(sorted(name for name in after if name.startswith("qrobot.backends.classical")))
print(sorted(name for name, kinds in after.items() if not kinds or kinds != before.get(name)))
"""


@pytest.mark.skipif(not _jit.available(), reason="numba is not installed")
def test_plans_ask_for_nothing_that_was_not_compiled() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    kernels, uncompiled = done.stdout.splitlines()
    for name in ("_climb", "_common", "anneal", "list_batches", "place"):
        assert f".{name}'" in kernels
    assert uncompiled == "[]"
