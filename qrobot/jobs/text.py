"""Jobs and their answers as text and as plain data."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from qrobot._text import columns
from qrobot.jobs.job import RemoteJob

if TYPE_CHECKING:
    import dimod

__all__ = ["jobs_table", "samples_report", "samples_text"]


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
