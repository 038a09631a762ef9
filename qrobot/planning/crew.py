"""More cores for long searches: other processes search too, with other seeds.

Each helper is a process of its own (``python -m qrobot.planning.worker``) that reads the
instance once and writes every better plan as a line. It ends at its deadline, when it is
told to, or when its parent is gone, so nothing outlives an interrupted run for long.
"""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import IO

from qrobot._children import child_environment
from qrobot.backends import Routes
from qrobot.problem import Instance

__all__ = ["Crew", "spare_cores"]

MOST = 3
"""More helpers than this find little more, and a Pi's memory bus is narrow."""

PATIENCE = 2.0
"""Seconds that a helper may take to write its last line."""


def spare_cores() -> int:
    """Return how many helpers this process may start; ``QROBOT_HELPERS`` overrules."""
    wanted = os.environ.get("QROBOT_HELPERS", "")
    if wanted.isdigit():
        return min(int(wanted), MOST)
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return max(0, min((usable or 1) - 1, MOST))


class Crew:
    """Helpers that search the same instance while this process searches too.

    Parameters
    ----------
    instance
        The question.
    backend
        Planner that the helpers run.
    seed
        Of this process; helper h uses ``seed + h``, h from 0.
    seconds
        Their deadline.
    max_work
        Their limit of work.
    helpers
        How many.
    """

    def __init__(
        self,
        instance: Instance,
        backend: str,
        seed: int,
        seconds: float | None,
        max_work: int | None,
        helpers: int,
    ) -> None:
        self._plans: list[Routes] = []
        self._processes: list[subprocess.Popen[bytes]] = []
        self._readers: list[threading.Thread] = []
        for h in range(helpers):
            task = pickle.dumps((instance, backend, seed + h, seconds, max_work))
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "qrobot.planning.worker"],
                env=child_environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for this process, which tells the others
            )
            assert process.stdin is not None
            assert process.stdout is not None
            reader = threading.Thread(
                target=self._talk, args=(process.stdin, process.stdout, task), daemon=True
            )
            reader.start()
            self._processes.append(process)
            self._readers.append(reader)

    def _talk(self, to: IO[bytes], back: IO[bytes], task: bytes) -> None:
        try:
            to.write(task)
            to.flush()
            for line in back:
                self._plans.append(json.loads(line))
        except (OSError, ValueError):
            return  # a helper that died costs its plans, nothing else

    def close(self, offer: Callable[[Routes], None], *, wait: float) -> None:
        """End the helpers and offer all plans that they found.

        Parameters
        ----------
        offer
            Called with every plan.
        wait
            Seconds to wait for helpers that are still within their limits.
        """
        for process, reader in zip(self._processes, self._readers, strict=True):
            reader.join(max(wait, 0.0))
            if process.stdin is not None:
                process.stdin.close()  # tells the helper to end
            reader.join(PATIENCE)
            if reader.is_alive():
                process.kill()
            process.wait()
            reader.join()
            if process.stdout is not None:
                process.stdout.close()
        for plan in self._plans:
            offer(plan)
