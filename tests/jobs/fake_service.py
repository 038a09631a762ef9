"""A remote service in a file: it outlives processes, needs no SDK and no network."""

from __future__ import annotations

import json
import time
from pathlib import Path

import dimod

from qrobot.jobs import Answer, Estimate


class FileService:
    """Jobs are lines of state in a folder; `hold` keeps them queued."""

    name = "file-service"
    title = "File Service"

    def __init__(self, folder: str | Path, *, hold: bool = False, usd: float | None = 0.5) -> None:
        self.folder = Path(folder)
        self.folder.mkdir(exist_ok=True)
        self.hold = hold
        self.usd = usd
        self.calls: list[str] = []
        self.errors: dict[str, list[Exception]] = {}

    def _call(self, name):
        self.calls.append(name)
        if self.errors.get(name):
            raise self.errors[name].pop(0)

    def _path(self, remote_id):
        return self.folder / f"{remote_id}.json"

    def state(self, remote_id, state=None):
        data = json.loads(self._path(remote_id).read_text())
        if state is not None:
            data["state"] = state
            self._path(remote_id).write_text(json.dumps(data))
        return data["state"]

    def estimate(self, bqm, **parameters):
        self._call("estimate")
        return Estimate(self.usd, None, "made up")

    def submit(self, bqm, *, label, keep, **parameters):
        self._call("submit")
        keep({"extra": parameters})
        remote_id = f"remote-{label}"
        state = "queued" if self.hold else "done"
        self._path(remote_id).write_text(json.dumps({"label": label, "state": state}))
        self._call("submitted")
        return remote_id, "shelf"

    def poll(self, job):
        self._call("poll")
        return self.state(job.remote_id), ""

    def fetch(self, job):
        self._call("fetch")
        bqm = job.bqm()
        samples = dimod.ExactSolver().sample(bqm).truncate(3)
        now = time.time()
        return Answer(samples, run=0.25, received=now - 1.0, solved=now)

    def cancel(self, job):
        self._call("cancel")
        self.state(job.remote_id, "cancelled")

    def find(self, job):
        self._call("find")
        remote_id = f"remote-{job.id}"
        return remote_id if self._path(remote_id).exists() else None
