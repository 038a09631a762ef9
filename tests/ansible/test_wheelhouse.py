"""The collector of wheels, with tiny wheels and a folder as index: no network is asked."""

from __future__ import annotations

import hashlib
import http.server
import importlib.metadata
import importlib.util
import io
import json
import os
import re
import signal
import socket
import subprocess
import sys
import sysconfig
import tarfile
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "ansible/controller/wheelhouse.py"
TARGETS = [("3.11", "aarch64"), ("3.13", "aarch64"), ("3.11", "x86_64"), ("3.13", "x86_64")]


@pytest.fixture(scope="session")
def python(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A Python with pip that sees what this one sees."""
    if importlib.util.find_spec("pip"):
        return sys.executable
    folder = tmp_path_factory.mktemp("pip")
    made = subprocess.run(
        [sys.executable, "-m", "venv", folder], capture_output=True, text=True, check=False
    )
    if made.returncode:
        pytest.skip("no pip here, and venv cannot make one")
    purelib = sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)})
    Path(purelib, "ours.pth").write_text(sysconfig.get_path("purelib") + "\n")
    # venv brings an old setuptools on 3.11, which would hide the one of the lock.
    uninstall = [folder / "bin/python", "-m", "pip", "uninstall", "--quiet", "--yes", "setuptools"]
    subprocess.run(uninstall, capture_output=True, check=True)
    return str(folder / "bin/python")


def built_by(name: str) -> None:
    """Skip where the build tool is not the one of the lock."""
    locked = re.search(rf"^{name}==(\S+)", (ROOT / "locks/build.txt").read_text(), re.MULTILINE)
    assert locked
    try:
        if importlib.metadata.version(name) == locked[1]:
            return
    except importlib.metadata.PackageNotFoundError:
        pass
    pytest.skip(f"{name} {locked[1]} of locks/build.txt is not installed here")


def wheel(folder: Path, name: str, tag: str = "py3-none-any", more: str = "", **files: str) -> Path:
    """Write a wheel, version 1.0, with one module and what else is given."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}-1.0-{tag}.whl"
    info = f"{name}-1.0.dist-info"
    files |= {
        f"{name}.py": f"tag = {tag!r}{more}\n",
        # Some packages guess where they end; the lock knows better.
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
        "Requires-Python: >=3.8,<3.11\n",
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}\n",
        f"{info}/RECORD": "".join(f"{file},,\n" for file in files),
    }
    with zipfile.ZipFile(path, "w") as archive:
        for file, text in files.items():
            archive.writestr(zipfile.ZipInfo(file), text)
    return path


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def pin(name: str, *paths: Path, marker: str = "") -> str:
    hashes = " \\\n".join(f"    --hash=sha256:{digest(path)}" for path in paths)
    return f"{name}==1.0{marker} \\\n{hashes}\n    # via\n    #   made up\n"


class House:
    """A lock, an index in a folder, and the program that collects from it."""

    def __init__(self, folder: Path, python: str) -> None:
        self.folder, self.python = folder, python
        self.index, self.dest = folder / "index", folder / "house"
        self.lock, self.uv_lock = folder / "lock.txt", folder / "uv.txt"
        program = {"uv-1.0.data/scripts/uv": "the program"}
        uv = [wheel(self.index, "uv", f"py3-none-manylinux_2_17_{m}.manylinux2014_{m}", **program)
              for m in ("aarch64", "x86_64")]  # fmt: skip
        self.uv_lock.write_text(pin("uv", *uv))
        self.own = wheel(folder, "qrobot")

    def start(self, *words: str, own: bool = False, **env: str) -> subprocess.Popen[str]:
        clean = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
        clean |= {"PIP_CONFIG_FILE": os.devnull, "PIP_NO_CACHE_DIR": "1"}
        here = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(self.index)}
        given = [] if own else ["--wheel", str(self.own)]
        return subprocess.Popen(
            [self.python, PROGRAM, "--json", "--lock", self.lock, "--uv-lock", self.uv_lock,
             "--dest", self.dest, *given, *words],
            env=clean | (env or here), text=True, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def run(self, *words: str, own: bool = False, **env: str) -> tuple[dict[str, Any], str]:
        process = self.start(*words, own=own, **env)
        out, told = process.communicate()
        assert process.returncode == 0, told
        return json.loads(out), told

    def refused(self, code: int, *words: str, **env: str) -> str:
        """Return the one sentence of a run that cannot do its work."""
        process = self.start(*words, **env)
        out, told = process.communicate()
        assert (process.returncode, out) == (code, "")
        assert "Traceback" not in told
        return told.splitlines()[-1]

    @property
    def files(self) -> set[str]:
        return {path.name for path in (self.dest / "files").iterdir()}


@pytest.fixture
def house(tmp_path: Path, python: str) -> House:
    return House(tmp_path, python)


def test_markers_and_tags_are_the_targets(house: House) -> None:
    """The Python that collects is one; what is collected is for another."""
    fast = [
        wheel(house.index, "fast", f"cp{n}-cp{n}-manylinux_2_{glibc}_{machine}")
        for n in (311, 313) for machine in ("aarch64", "x86_64") for glibc in (17, 28, 34)
    ]  # fmt: skip
    stable = [wheel(house.index, "stable", f"cp310-abi3-manylinux2014_{machine}")
              for machine in ("aarch64", "x86_64")]  # fmt: skip
    pure = {name: wheel(house.index, name) for name in ("old", "arm", "windows", "always")}
    house.lock.write_text(
        pin("fast", *fast) + pin("stable", *stable) + pin("always", pure["always"])
        + pin("old", pure["old"], marker=" ; python_full_version < '3.12'")
        + pin("arm", pure["arm"], marker=" ; platform_machine == 'aarch64'")
        + pin("windows", pure["windows"], marker=" ; sys_platform == 'win32'")
    )  # fmt: skip
    ids = set()
    for release, machine in TARGETS:
        document, _ = house.run("--python", release, "--machine", machine)
        cp = "cp" + release.replace(".", "")
        want = {
            "qrobot-1.0-py3-none-any.whl",
            "always-1.0-py3-none-any.whl",
            f"fast-1.0-{cp}-{cp}-manylinux_2_28_{machine}.whl",
            f"stable-1.0-cp310-abi3-manylinux2014_{machine}.whl",
        }
        want |= {"old-1.0-py3-none-any.whl"} if release == "3.11" else set()
        want |= {"arm-1.0-py3-none-any.whl"} if machine == "aarch64" else set()
        assert {file["name"] for file in document["files"]} == want
        assert document["uv"]["name"].endswith(f"manylinux2014_{machine}.whl")
        for file in [*document["files"], document["uv"]]:
            path = house.dest / "files" / file["name"]
            assert (file["sha256"], file["size"]) == (digest(path), path.stat().st_size)
        lines = {f"{file['name'].split('-')[0]}==1.0 --hash=sha256:{file['sha256']}"
                 for file in document["files"]}  # fmt: skip
        assert set(document["requirements"].splitlines()) == lines
        ids.add(document["id"])
    assert len(ids) == 4


def simple(house: House, *names: str) -> list[Path]:
    paths = [wheel(house.index, name) for name in names]
    house.lock.write_text("".join(map(pin, names, paths)))
    return paths


def test_a_second_run_asks_nobody_and_changes_nothing(house: House) -> None:
    simple(house, "one", "two")
    first, _ = house.run()
    assert first["changed"]
    assert re.fullmatch(r"1\.0-edge-[0-9a-f]{8}", first["id"])
    path = house.dest / "edge-3.13-aarch64.json"
    before = path.read_bytes(), path.stat().st_mtime_ns
    # No index at all: whoever asked would be refused.
    second, told = house.run(PIP_NO_INDEX="1")
    assert second == first | {"changed": False}
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before
    assert "to fetch" not in told


def test_the_profiles_share_the_files_and_have_ids_of_their_own(house: House) -> None:
    simple(house, "one")
    first, _ = house.run()
    second, _ = house.run("--profile", "solver", PIP_NO_INDEX="1")
    assert first["id"].replace("edge", "solver") == second["id"]


def test_another_wheel_of_qrobot_is_another_release(house: House) -> None:
    simple(house, "one")
    first, _ = house.run()
    wheel(house.folder, "qrobot", more="  # changed")
    second, _ = house.run()
    assert second["changed"]
    assert second["id"] != first["id"]
    assert f"qrobot==1.0 --hash=sha256:{digest(house.own)}" in second["requirements"]
    wheel(house.folder, "qrobot")
    assert house.run()[0]["id"] == first["id"]


def test_a_broken_file_of_the_store_is_fetched_again(house: House) -> None:
    one, _ = simple(house, "one", "two")
    house.run()
    there = house.dest / "files" / one.name
    there.write_bytes(one.read_bytes()[:-1])
    told = house.refused(3, PIP_NO_INDEX="1")
    assert "1 of 1 wheels is missing" in told
    assert "one-1.0" in told
    assert one.name not in house.files
    document, told = house.run()
    assert "1 of 3 wheels to fetch" in told
    assert not document["changed"]
    assert there.read_bytes() == one.read_bytes()


def test_other_bytes_than_the_lock_allows_are_refused(house: House) -> None:
    one, two = simple(house, "one", "two")
    wheel(house.index, "one", more="  # other")
    told = house.refused(3)
    assert one.name in told
    assert "other bytes" in told
    assert str(house.index) not in told
    assert one.name not in house.files
    assert two.name in house.files


def test_what_is_missing_is_named_and_the_rest_is_kept(house: House) -> None:
    one, two, three = simple(house, "one", "two", "three")
    kept = two.rename(house.folder / two.name)
    told = house.refused(3)
    assert "1 of 4 wheels is missing" in told
    assert "no file that the lock allows for Python 3.13 on aarch64 (two-1.0)" in told
    assert {one.name, three.name} <= house.files
    kept.rename(two)
    document, told = house.run()
    assert "1 of 4 wheels to fetch" in told
    assert len(document["files"]) == 4


def test_another_fault_of_pip_is_told_as_it_is(house: House) -> None:
    """Such as a disk that is full: nobody is sent to look for another index."""
    simple(house, "one")
    pip = house.folder / "pip.py"
    pip.write_text("raise SystemExit('ERROR: No space left, said http:' + '/' * 2 + 'a:b@c/d')")
    here = {"PIP_NO_INDEX": "1", "PYTHONPATH": str(house.folder)}
    told = house.refused(3, **here)
    assert "pip failed, ERROR: No space left, said ... (one-1.0, uv-1.0)" in told


def test_no_network_is_one_sentence(house: House) -> None:
    simple(house, "one", "two")
    with socket.socket() as closed:  # bound and not listening: nobody answers there
        closed.bind(("127.0.0.1", 0))
        address = f"http:{'/' * 2}127.0.0.1:{closed.getsockname()[1]}"
        told = house.refused(3, PIP_INDEX_URL=address)
    assert "3 of 3 wheels are missing: no index answered (one-1.0, two-1.0, uv-1.0)" in told
    assert "127.0.0.1" not in told


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


def test_a_killed_run_leaves_whole_files_and_the_next_one_goes_on(
    house: House, slow: tuple[str, threading.Event]
) -> None:
    names = [f"a{number}" for number in range(8)]
    paths = simple(house, *names, "nine")
    address, stuck = slow
    process = house.start(PIP_NO_INDEX="1", PIP_FIND_LINKS=address)
    assert stuck.wait(120)
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


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--python", "3.12"], "--python: 3.12 is not known; give 3.11 or 3.13"),
        (["--machine", "riscv64"], "--machine: riscv64 is not known; give aarch64 or x86_64"),
        (["--profile", "all"], "--profile: all is not known; give solver or edge or lab"),
        (["--lock", "/nowhere/lock.txt"], "/nowhere/lock.txt: lock: not readable"),
        (["--wheel", "/nowhere/qrobot-1.0-py3-none-any.whl"], "not readable"),
        (["--wheel", "/nowhere/other-1.0-py3-none-any.whl"], "no wheel of qRobot"),
    ],
)
def test_an_argument_that_cannot_be_used(house: House, words: list[str], sentence: str) -> None:
    simple(house, "one")
    assert sentence in house.refused(2, *words)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("one==1.0\n", "one has no hash"), ("# nothing\n", "pins nothing"), ("a==!\n", "no lock")],
)
def test_a_lock_that_is_none(house: House, text: str, sentence: str) -> None:
    house.lock.write_text(text)
    assert sentence in house.refused(2)
