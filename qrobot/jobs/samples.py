"""What is told of a remote job: the info of its samples, where the seconds went, and both as text.

The service's clock and ours may differ by minutes, so instants of the two are never
subtracted from each other: only lengths are.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from qrobot._text import columns
from qrobot.jobs.job import RemoteJob
from qrobot.jobs.redaction import redact, redact_data

__all__ = [
    "PARTS",
    "add_job",
    "breakdown",
    "empty",
    "jobs_table",
    "json_data",
    "samples_report",
    "samples_text",
    "timing_fields",
]

if TYPE_CHECKING:
    import dimod


def add_job(samples: dimod.SampleSet, job: RemoteJob) -> dimod.SampleSet:
    """Put what is known about a job into the info of its samples; return them."""
    info = redact_data(json_data(samples.info))
    samples.info.clear()
    samples.info.update(info)
    estimate, timing = job.estimate.to_dict(), dict(job.timings)
    remote = {"job": job.id, "state": job.state, "estimate": estimate, "timing": timing}
    ids = {"remote_id": job.remote_id, "device": job.device}
    samples.info["remote"] = redact_data(remote) | {
        name: redact(value, guess=False) for name, value in ids.items()
    }
    return samples


def json_data(data: Any) -> Any:
    """Return data that JSON can hold."""
    if isinstance(data, dict):
        return {str(key): json_data(value) for key, value in data.items()}
    if isinstance(data, list | tuple | set | frozenset):
        return [json_data(value) for value in data]
    if data is None or isinstance(data, bool | int | float | str):
        return data
    if hasattr(data, "tolist"):  # numpy
        return json_data(data.tolist())
    return str(data)


def empty(bqm: dimod.BinaryQuadraticModel, remote: dict[str, Any]) -> dimod.SampleSet:
    """Return samples without a row, with `remote` in the info."""
    import dimod
    import numpy as np

    names = list(bqm.variables)
    return dimod.SampleSet.from_samples(
        (np.zeros((0, len(names)), dtype=np.int8), names),
        vartype=bqm.vartype,
        energy=np.zeros(0),
        info={"remote": redact_data(remote)},
    )


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


def jobs_table(jobs: list[RemoteJob]) -> str:
    """Return jobs as aligned text."""
    if not jobs:
        return "no jobs"
    heads = ("job", "backend", "device", "state", "submitted", "variables", "estimate", "problem")
    rows = []
    for job in jobs:
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(job.submitted))
        usd = "" if job.estimate.usd is None else f"{job.estimate.usd:.4g} USD"
        note = job.problem
        if job.state == "submitting" and not note:
            note = "the service's answer was not heard; 'qrobot jobs list --refresh' looks for it"
        rows.append(
            (job.id, job.backend, job.device, job.state, when, str(job.variables), usd, note)
        )
    return columns(heads, rows, ruled=False)


def samples_report(job: RemoteJob, samples: dimod.SampleSet) -> dict[str, Any]:
    """Return what is known about a fetched job as plain data."""
    energies = samples.record.energy
    return job.to_dict() | {
        "reads": int(samples.record.num_occurrences.sum()),
        "rows": len(samples),
        "least_energy": float(energies.min()) if len(samples) else None,
    }


def samples_text(report: dict[str, Any]) -> str:
    """Return a report of `samples_report` as a few plain lines."""
    best = "no rows" if report["least_energy"] is None else f"least {report['least_energy']:g}"
    seconds = ", ".join(f"{name} {value:.3g} s" for name, value in report["timings"].items())
    return "\n".join(
        [
            f"{report['id']}: {report['backend']} on {report['device']}, {report['state']}",
            f"{report['variables']} variables, {report['reads']} reads, energy {best}",
            f"time: {seconds or 'not known'}",
        ]
    )
