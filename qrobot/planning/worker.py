"""One helper of a `Crew`: reads a task from the standard input, writes plans as lines.

Only ever started by `Crew`, over pipes that nobody else can reach.
"""

from __future__ import annotations

import os
import pickle
import sys
import time
from collections.abc import Sequence

from qrobot._json import json_text
from qrobot._processes import end_with_parent
from qrobot.backends import Stop
from qrobot.backends.registry import get_planner

__all__ = ["main"]


NICENESS = 5
"""Whoever asked must not wait for those that help."""


def main() -> None:
    """Search until the limits are reached or the parent is gone."""
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
