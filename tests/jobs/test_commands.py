"""`qrobot jobs` and `qrobot doctor`."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import dimod
import pytest
from click.testing import CliRunner
from jobs.fake_service import FileService
from jobs.test_redaction import FORMS, plant

from qrobot.backends.jobs import refresh_all
from qrobot.cli import doctor, jobs, main
from qrobot.errors import InputError
from qrobot.health.inventory import EXTRAS, packages_of
from qrobot.jobs import JobOptions, JobStore, run_job

BQM = dimod.BQM({"a": 1.0, "b": -1.0}, {("a", "b"): 0.5}, 0.25, "BINARY")


@pytest.fixture
def service(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FileService:
    service = FileService(tmp_path / "service", hold=True)
    monkeypatch.setattr("qrobot.backends.get", lambda name: service)
    return service


def run(command: object, *words: str, code: int = 0) -> str:
    done = CliRunner().invoke(command, words, catch_exceptions=False)  # type: ignore[arg-type]
    assert done.exit_code == code, done.output
    return done.output


def test_list_fetch_cancel_forget(service: FileService, tmp_path: Path) -> None:
    assert run(jobs.command, "list") == "no jobs\n"
    names = [run_job(service, BQM, JobOptions(wait=False)).info["remote"]["id"] for _ in range(2)]
    text = run(jobs.command, "list")
    assert all(name in text for name in names)
    assert "queued" in text
    service.state(f"remote-{names[0]}", "done")
    rows = json.loads(run(jobs.command, "list", "--refresh", "--state", "done", "--json"))
    assert [row["id"] for row in rows] == [names[0]]
    out = tmp_path / "samples.json"
    text = run(jobs.command, "fetch", names[0][:9], "--output", str(out))
    assert "2 variables, 3 reads, energy least -0.75" in text
    assert dimod.SampleSet.from_serializable(json.loads(out.read_text())).first.energy == -0.75
    report = json.loads(run(jobs.command, "fetch", names[0], "--json"))
    assert report["least_energy"] == -0.75
    assert set(report["timings"]) == {"submit", "latency", "queue", "run", "return"}
    assert run(jobs.command, "cancel", names[1]) == f"{names[1]} is cancelled\n"
    assert run(jobs.command, "forget", "--days", "0") == "2 jobs are forgotten\n"
    with pytest.raises(InputError, match="see 'qrobot jobs list'"):
        run(jobs.command, "fetch", "qr-none")


def test_a_service_that_is_down_does_not_hide_the_list(service: FileService) -> None:
    name = run_job(service, BQM, JobOptions(wait=False)).info["remote"]["id"]
    service.errors = {"poll": [ValueError("down")]}
    text = run(jobs.command, "list", "--refresh")
    assert f"not refreshed: file-service, job {name}: File Service failed (ValueError" in text
    assert name in text


def test_the_doctor_tells_what_is_there_and_no_secret(home: Path) -> None:
    text = run(doctor.command)
    assert "D-Wave Leap     absent; run 'dwave setup'" in text
    assert "no problem was found" in text
    plant(home)
    text = run(doctor.command) + run(doctor.command, "--json")
    assert "present: file" in text
    for form in FORMS:
        assert form not in text
    data = json.loads(run(doctor.command, "--json"))
    assert all(one["present"] for one in data["credentials"].values())
    assert data["folders"]["jobs"]["writable"]


def test_the_doctor_finds_problems(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant(home)
    (home / ".aws" / "credentials").chmod(0o644)
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/nowhere")
    text = run(doctor.command, code=1)
    assert "can be read by others; run chmod 600" in text
    assert "the jobs folder /proc/nowhere/qrobot cannot be written to" in text


def test_the_extras_are_those_of_the_project() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]

    def names(requirements: list[str]) -> list[str]:
        found = (r.split(">")[0].split("<")[0].split("=")[0].strip() for r in requirements)
        return sorted(name for name in found if not name.startswith("qrobot"))

    assert set(packages_of("")) <= set(names(project["dependencies"]))
    for extra in EXTRAS:
        assert names(project["optional-dependencies"][extra]) == packages_of(extra)


def test_one_dead_job_does_not_hide_the_others(service: FileService) -> None:
    service.hold = True
    bqm = dimod.BQM({"a": 1.0}, {}, 0.0, "BINARY")
    ids = [run_job(service, bqm, JobOptions(wait=False)).info["remote"]["id"] for _ in range(3)]
    service.hold = False
    with JobStore() as store:
        jobs = {job.id: job for job in store.list()}
        for one in ids[:2]:
            service.state(jobs[one].remote_id, "done")
        service._path(jobs[ids[2]].remote_id).unlink()  # the newest, which is asked first
        troubles = refresh_all(store.list(), store, lambda _: service)
        assert [store.get(one).state for one in ids] == ["done", "done", "queued"]
    assert len(troubles) == 1
    assert ids[2] in troubles[0]


def test_forgetting_needs_an_age(capsys: pytest.CaptureFixture[str]) -> None:
    for days in ("-1", "nan", "inf"):
        with pytest.raises(SystemExit) as ended:
            main(["jobs", "forget", "--days", days])
        assert ended.value.code == 2
        assert "--days" in capsys.readouterr().err
