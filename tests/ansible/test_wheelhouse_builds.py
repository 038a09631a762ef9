"""The collector of wheels when it is cut off or runs twice, and what it builds itself."""

from __future__ import annotations

import http.server
import io
import json
import os
import signal
import tarfile
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from collector_house import ROOT, House, built_by, digest, pin, simple
from processes import HANG


class Slow(http.server.SimpleHTTPRequestHandler):
    """An index that sends half of one file and then nothing."""

    stuck: threading.Event
    go_on: threading.Event

    def do_GET(self) -> None:
        if "nine" not in self.path:
            return super().do_GET()
        self.send_response(200)
        self.send_header("Content-Length", "1000")
        self.end_headers()
        self.wfile.write(b"P" * 500)
        self.wfile.flush()
        self.stuck.set()
        self.go_on.wait()
        return None

    def log_message(self, *words: object) -> None:
        pass


@pytest.fixture
def slow(house: House) -> Iterator[tuple[str, threading.Event]]:
    class Handler(Slow):
        stuck, go_on = threading.Event(), threading.Event()

        def __init__(self, *words: Any) -> None:
            super().__init__(*words, directory=str(house.index))

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http:{'/' * 2}127.0.0.1:{server.server_port}/", Handler.stuck
    Handler.go_on.set()
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.mark.slow
def test_a_killed_run_leaves_whole_files_and_the_next_one_goes_on(
    house: House, slow: tuple[str, threading.Event]
) -> None:
    names = [f"a{number}" for number in range(8)]
    paths = simple(house, *names, "nine")
    address, stuck = slow
    process = house.start(PIP_NO_INDEX="1", PIP_FIND_LINKS=address)
    assert stuck.wait(HANG)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert house.files == {house.own.name, *(path.name for path in paths[:8])}
    for path in paths[:8]:
        assert digest(house.dest / "files" / path.name) == digest(path)
    assert not (house.dest / "edge-3.13-aarch64.json").exists()
    document, told = house.run()
    assert "2 of 10 wheels to fetch" in told
    assert len(document["files"]) == 10
    assert not [*house.dest.glob("tmp-*")]


@pytest.mark.slow
def test_two_at_once_do_not_disturb_each_other(house: House) -> None:
    simple(house, "one", "two")
    both = [house.start(), house.start()]
    answers = [process.communicate() for process in both]
    assert [process.returncode for process in both] == [0, 0], answers
    documents = [json.loads(out) for out, _ in answers]
    assert documents[0]["id"] == documents[1]["id"]
    assert sorted(document["changed"] for document in documents) == [False, True]


def sdist(folder: Path) -> Path:
    """Write a source archive as docplex is published: with a setup.py and no wheel."""
    path = folder / "docplex-1.0.tar.gz"
    files = {
        "setup.py": "from setuptools import setup\nsetup(name='docplex', version='1.0', "
        "packages=['docplex'])\n",
        "docplex/__init__.py": "made = 'here'\n",
        "PKG-INFO": "Metadata-Version: 2.1\nName: docplex\nVersion: 1.0\n",
    }
    with tarfile.open(path, "w:gz") as archive:
        for name, text in files.items():
            entry = tarfile.TarInfo(f"docplex-1.0/{name}")
            entry.size = len(text)
            archive.addfile(entry, io.BytesIO(text.encode()))
    return path


@pytest.mark.slow
def test_a_source_archive_is_built_once_and_always_to_the_same_bytes(house: House) -> None:
    built_by("setuptools")
    source = sdist(house.index)
    house.lock.write_text(pin("docplex", source))
    first, told = house.run()
    assert told.count("building docplex-1.0.tar.gz") == 1
    name = "docplex-1.0-py3-none-any.whl"
    made = digest(house.dest / "files" / name)
    assert f"docplex==1.0 --hash=sha256:{made}" in first["requirements"]
    other, told = house.run("--python", "3.11")
    assert "building" not in told
    assert made in other["requirements"]
    house.dest = house.folder / "elsewhere"
    again, _ = house.run()
    assert again["id"] == first["id"]

    source.write_bytes(source.read_bytes() + b"\0")  # other bytes than the lock allows
    (house.dest / "files" / name).unlink()
    assert "other bytes" in house.refused(3)
    assert name not in house.files


@pytest.mark.slow
def test_the_same_checkout_gives_the_same_wheel(house: House) -> None:
    built_by("hatchling")
    simple(house, "one")
    first, _ = house.run(own=True)
    house.dest = house.folder / "elsewhere"
    second, _ = house.run(own=True)
    assert first["id"] == second["id"]
    (own,) = [file for file in first["files"] if file["name"].startswith("qrobot-")]
    with zipfile.ZipFile(house.dest / "files" / own["name"]) as archive:
        assert archive.read("qrobot/errors.py") == (ROOT / "qrobot/errors.py").read_bytes()
        assert not [name for name in archive.namelist() if name.endswith(".pyc")]


def test_the_program_uv_is_taken_out_of_its_wheel(house: House) -> None:
    simple(house, "one")
    document, _ = house.run()
    program = Path(document["uv"]["binary"])
    assert program == house.dest / "uv-1.0-aarch64/uv"
    assert program.read_text() == "the program"
    assert program.stat().st_mode & 0o777 == 0o755
    assert document["uv"]["binary_sha256"] == digest(program)
    program.write_text("another")
    house.run(PIP_NO_INDEX="1")
    assert program.read_text() == "the program"
