"""Where the seconds of a remote job went, from what the service and our clock tell.

The service's clock and ours may differ by minutes, so instants of the two are never
subtracted from each other: only lengths are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["PARTS", "breakdown", "timing_fields"]

PARTS = ("submit", "latency", "queue", "run", "return")


def breakdown(
    *,
    submit: float,
    total: float,
    fetch: float,
    run: float | None = None,
    received: float | None = None,
    solved: float | None = None,
) -> dict[str, float]:
    """Return the seconds of each part; they add up to the total.

    Parameters
    ----------
    submit
        From the call until the service confirmed that it took the job.
    total
        From the call until the samples were here.
    fetch
        The download of the answer.
    run
        The device's own work, as the service tells.
    received, solved
        Instants of the service's clock; their difference is what it had the job for.

    Notes
    -----
    ``queue`` is what the service had the job for, less the device's own work; ``latency`` is
    the rest: the way over the network and the time until we asked. Where the service tells
    no instants, ``queue`` holds that rest and ``latency`` is zero.
    """
    rest = max(0.0, total - submit - fetch)
    work = min(max(run or 0.0, 0.0), rest)
    if received is not None and solved is not None and solved >= received:
        queue = min(max(0.0, solved - received - work), rest - work)
        latency = rest - work - queue
    else:
        queue, latency = rest - work, 0.0
    parts = (submit, latency, queue, work, fetch)
    return {name: float(value) for name, value in zip(PARTS, parts, strict=True)}


def timing_fields(info: Mapping[str, Any]) -> dict[str, float]:
    """Return the timings of a SampleSet's info, named as the fields of `planning.Timing`.

    Empty for samples that did not come from a remote backend.
    """
    remote = info.get("remote")
    timing = remote.get("timing") if isinstance(remote, Mapping) else None
    if not isinstance(timing, Mapping):
        return {}
    names = {"return": "return_"}
    return {names.get(name, name): float(timing[name]) for name in PARTS if name in timing}
