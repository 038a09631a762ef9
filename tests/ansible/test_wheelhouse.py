"""The collector of wheels, with tiny wheels and a folder as index: no network is asked."""

from __future__ import annotations

import re
import socket

import pytest
from collector_house import House, digest, pin, simple, wheel

TARGETS = [("3.11", "aarch64"), ("3.13", "aarch64"), ("3.11", "x86_64"), ("3.13", "x86_64")]


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


@pytest.mark.slow
def test_the_profiles_share_the_files_and_have_ids_of_their_own(house: House) -> None:
    simple(house, "one")
    first, _ = house.run()
    second, _ = house.run("--profile", "solver", PIP_NO_INDEX="1")
    assert first["id"].replace("edge", "solver") == second["id"]


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--python", "3.12"], "--python: 3.12 is not known; give 3.11 or 3.13"),
        (["--machine", "riscv64"], "--machine: riscv64 is not known; give aarch64 or x86_64"),
        (["--profile", "all"], "--profile: all is not known; give solver or edge or lab"),
        (["--lock", "/nowhere/lock.txt"], "/nowhere/lock.txt: lock: not readable"),
        (["--wheel", "/nowhere/qrobot-1.0-py3-none-any.whl"], "not readable"),
        (["--wheel", "/nowhere/other-1.0-py3-none-any.whl"], "is not a wheel of qRobot"),
    ],
)
def test_an_argument_that_cannot_be_used(house: House, words: list[str], sentence: str) -> None:
    simple(house, "one")
    assert sentence in house.refused(2, *words)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("one==1.0\n", "one has no hash"),
        ("# nothing\n", "pins nothing"),
        ("a==!\n", "is not a lock"),
    ],
)
def test_a_lock_that_is_none(house: House, text: str, sentence: str) -> None:
    house.lock.write_text(text)
    assert sentence in house.refused(2)
