"""The store: private, durable, shared by processes, and clear when it cannot be used."""

from __future__ import annotations

import sqlite3
import stat
import threading
from pathlib import Path

import dimod
import pytest

from qrobot.errors import InputError
from qrobot.jobs import Estimate, JobStore, RemoteJob, default_path
from qrobot.jobs.job import pack_model


def job(**known: object) -> RemoteJob:
    return RemoteJob("file-service", **known)


def test_the_file_is_for_its_owner_only(tmp_path: Path) -> None:
    path = tmp_path / "state" / "jobs.sqlite3"
    with JobStore(path) as store:
        store.add(job())
        assert len(list(path.parent.iterdir())) == 3  # with -wal and -shm
        for file in path.parent.iterdir():
            assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_a_file_open_to_others_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "jobs.sqlite3"
    path.touch(0o644)
    JobStore(path).close()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_jobs_come_back_as_they_were(tmp_path: Path) -> None:
    bqm = dimod.BQM({("x", 1, 2): 1.5, "y": -1, 7: 0}, {(("x", 1, 2), "y"): 0.25}, 3, "SPIN")
    one = job(
        variables=3,
        model=pack_model(bqm),
        context={"a": [1, 2.5, None]},
        estimate=Estimate(1.5, 2.0, "guess"),
        timings={"run": 0.125},
    )
    with JobStore(tmp_path / "j") as store:
        store.add(one)
    with JobStore(tmp_path / "j") as store:
        again = store.get(one.id)
        assert again == one
        assert again.bqm() == bqm
        assert list(again.bqm().variables) == list(bqm.variables)
        one.state, one.remote_id = "done", "far-away"
        store.update(one)
        assert store.get("far-away") == one
        assert store.get(one.id[:7]) == one
        samples = dimod.ExactSolver().sample(bqm)
        assert store.answer(one) is None
        store.keep_answer(one, samples)
        assert store.answer(one) == samples


def test_views_and_python_numbers_can_be_packed() -> None:
    bqm = dimod.BQM({"a": 1}, {"ab": -2}, 1, "BINARY", dtype=object)
    assert RemoteJob("x", model=pack_model(bqm)).bqm() == bqm
    assert RemoteJob("x", model=pack_model(bqm.spin)).bqm() == bqm.spin
    with pytest.raises(InputError, match="a label of the model"):
        pack_model(dimod.BQM({frozenset("a"): 1}, {}, 0, "BINARY"))


def test_an_id_that_looks_like_a_token_is_kept(tmp_path: Path) -> None:
    name = "task-0123456789abcdef0123456789abcdef"
    with JobStore(tmp_path / "j") as store:
        store.add(job(remote_id=name, problem=f"refused {name}"))
        assert store.get(name).remote_id == name
        assert name not in store.get(name).problem


def test_names_must_be_unmistakable(tmp_path: Path) -> None:
    with JobStore(tmp_path / "j") as store:
        store.add(job(id="qr-aaaa1"))
        store.add(job(id="qr-aaaa2"))
        for wrong, why in [("qr-aaaa", "more than one"), ("qr-b", "no job"), ("qr", "no job")]:
            with pytest.raises(InputError, match=why):
                store.get(wrong)
        with pytest.raises(InputError, match="no job"):
            store.get("")
        with pytest.raises(InputError, match="is not a state"):
            store.list("lost")


def test_only_old_jobs_that_ended_are_forgotten(tmp_path: Path) -> None:
    with JobStore(tmp_path / "j") as store:
        store.add(job(id="qr-old-done", submitted=1.0, state="done"))
        store.add(job(id="qr-old-open", submitted=1.0, state="queued"))
        store.add(job(id="qr-new-done", state="done"))
        assert store.prune(30) == 1
        assert [one.id for one in store.list()] == ["qr-new-done", "qr-old-open"]


def test_several_writers(tmp_path: Path) -> None:
    path = tmp_path / "j"

    def write(number: int) -> None:
        with JobStore(path) as store:
            for i in range(10):
                one = store.add(job(id=f"qr-{number}-{i:03}"))
                one.state = "done"
                store.update(one)

    threads = [threading.Thread(target=write, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with JobStore(path) as store:
        assert len(store.list("done")) == 40


def test_a_new_file_that_another_prepares_is_waited_for(tmp_path: Path) -> None:
    # SQLite itself refuses to switch the journal at once when another has begun to write.
    path = tmp_path / "j"
    other = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    other.execute("BEGIN IMMEDIATE")
    later = threading.Timer(0.4, other.execute, ["COMMIT"])
    later.start()
    with JobStore(path) as store:
        assert store.add(job()).id
    later.join()
    other.close()


def test_what_cannot_be_used_is_refused_with_advice(tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    broken.write_bytes(b"this is no database, but long enough to look at" * 50)
    with pytest.raises(InputError, match="cannot keep jobs"):
        JobStore(broken)
    with pytest.raises(InputError, match="set XDG_STATE_HOME"):
        JobStore("/proc/nowhere/jobs")
    with JobStore(tmp_path / "newer"):
        pass
    db = sqlite3.connect(tmp_path / "newer")
    db.execute("PRAGMA user_version=99")
    db.close()
    with pytest.raises(InputError, match="newer qrobot"):
        JobStore(tmp_path / "newer")


def test_the_place_follows_xdg(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert default_path() == tmp_path / "qrobot" / "jobs.sqlite3"
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert default_path() == tmp_path / ".local" / "state" / "qrobot" / "jobs.sqlite3"
