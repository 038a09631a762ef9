"""Samples of remote jobs: empty ones, and infos that hold plain data and no secret."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from qrobot.jobs.job import RemoteJob
from qrobot.jobs.redaction import redact, redact_data

if TYPE_CHECKING:
    import dimod

__all__ = ["empty", "tell"]


def tell(samples: dimod.SampleSet, job: RemoteJob) -> dimod.SampleSet:
    """Put what is known about a job into the info of its samples; return them."""
    info = redact_data(plain(samples.info))
    samples.info.clear()
    samples.info.update(info)
    remote = redact_data(_remote_info(job))
    ids = {"remote_id": job.remote_id, "device": job.device}
    samples.info["remote"] = remote | {k: redact(v, guess=False) for k, v in ids.items()}
    return samples


def _remote_info(job: RemoteJob) -> dict[str, Any]:
    data = job.to_dict()
    return {
        "job": data["id"],
        "remote_id": data["remote_id"],
        "device": data["device"],
        "state": data["state"],
        "estimate": data["estimate"],
        "timing": data["timings"],
    }


def plain(data: Any) -> Any:
    """Return data that JSON can hold."""
    if isinstance(data, dict):
        return {str(key): plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple | set | frozenset):
        return [plain(value) for value in data]
    if data is None or isinstance(data, bool | int | float | str):
        return data
    if hasattr(data, "tolist"):  # numpy
        return plain(data.tolist())
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
