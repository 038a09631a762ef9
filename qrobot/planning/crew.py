"""More cores for long searches: other processes search too, with other seeds.

Each helper is a process of its own (`main` of this file) that reads the
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
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import IO, Any

from qrobot._json import json_text
from qrobot._machine import usable_cores
from qrobot._processes import child_environment, end_with_parent, python_command
from qrobot.backends import Routes, Stop
from qrobot.backends.registry import get_planner
from qrobot.problem import Instance

__all__ = ["Crew", "main", "spare_cores"]

MOST = 3
"""More helpers than this find little more, and a Pi's memory bus is narrow."""

DELIVERY = 0.2
"""Seconds between looks at what helpers have found."""

NICENESS = 5
"""Helpers give way to the process that started them."""


def spare_cores() -> int:
    """Return how many helpers this process may start; ``QROBOT_HELPERS`` overrules."""
    wanted = os.environ.get("QROBOT_HELPERS", "")
    if wanted.isdigit():
        return min(int(wanted), MOST)
    return max(0, min(usable_cores() - 1, MOST))


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
        Their deadline from now on, starting included.
    max_work
        Their limit of work.
    helpers
        How many.
    aim
        The objective as the planner takes it (`Best.aim`); nothing: the distance.
    """

    def __init__(
        self,
        instance: Instance,
        backend: str,
        seed: int,
        seconds: float | None,
        max_work: int | None,
        helpers: int,
        aim: Mapping[str, Any] | None = None,
    ) -> None:
        # The monotonic clock is one for all processes, however late a helper gets going.
        end = None if seconds is None else time.monotonic() + seconds
        question = pickle.dumps((instance, backend, end, max_work, dict(aim or {})))
        self._latest: list[deque[bytes]] = []
        self._looked = 0.0
        self._processes: list[subprocess.Popen[bytes]] = []
        self._readers: list[threading.Thread] = []
        for h in range(helpers):
            process = subprocess.Popen(
                python_command("qrobot.planning.crew"),
                env=child_environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for this process, which tells the others
            )
            assert process.stdin is not None
            assert process.stdout is not None
            latest: deque[bytes] = deque(maxlen=1)  # its plans only get better
            reader = threading.Thread(
                target=_talk,
                args=(process.stdin, process.stdout, question + pickle.dumps(seed + h), latest),
                daemon=True,
            )
            reader.start()
            self._latest.append(latest)
            self._processes.append(process)
            self._readers.append(reader)

    def deliver(self, offer: Callable[[Routes], None], *, now: bool = False) -> None:
        """Offer the plans that helpers have found since the last time.

        Parameters
        ----------
        offer
            Called with every plan.
        now
            Even when the last look was a moment ago.
        """
        if not now and time.monotonic() - self._looked < DELIVERY:
            return
        self._looked = time.monotonic()
        for latest in self._latest:
            if latest:
                offer(json.loads(latest.popleft()))

    def close(self, offer: Callable[[Routes], None], *, wait: float) -> None:
        """End the helpers and offer what they have found.

        Parameters
        ----------
        offer
            Called with the last plan of each.
        wait
            Seconds to wait for helpers that are still within their limits.
        """
        for reader in self._readers:
            reader.join(max(wait, 0.0))
        for process in self._processes:
            process.kill()  # every better plan was written when it was found
        for process, reader in zip(self._processes, self._readers, strict=True):
            process.wait()
            reader.join()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with suppress(OSError):  # what was not written yet
                        pipe.close()
        self.deliver(offer, now=True)


def _talk(to: IO[bytes], back: IO[bytes], task: bytes, latest: deque[bytes]) -> None:
    try:
        to.write(task)
        to.flush()
        for line in back:
            if line.endswith(b"\n"):  # not cut off by the end
                latest.append(line)
    except (OSError, ValueError):
        return  # a helper that died costs its plans, nothing else


def main() -> None:
    """Help a `Crew`: read a task, write better plans as lines, until the limits are reached.

    The pipes are those of the process that started this one; nobody else can reach them.
    """
    end_with_parent()
    source = sys.stdin.buffer
    instance, backend, end, max_work, aim = pickle.load(source)  # noqa: S301 - our parent's
    seed = pickle.load(source)  # noqa: S301
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    stop = Stop(None if end is None else max(end - time.monotonic(), 0.0), max_work)

    def tell(routes: Sequence[Sequence[int]], _cost: float) -> None:
        sys.stdout.write(json_text([list(map(int, route)) for route in routes]) + "\n")
        sys.stdout.flush()

    get_planner(backend).search(instance, stop=stop, seed=seed, on_best=tell, **aim)


if __name__ == "__main__":
    main()
