"""Whole files or none."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from qrobot._files import MAX_BYTES, read_text, write_bytes_atomic, write_text_atomic
from qrobot.errors import InputError


@contextlib.contextmanager
def unprivileged() -> Iterator[None]:
    """Drop root's right to read and write everything."""
    root = os.geteuid() == 0
    if root:
        os.seteuid(65534)
    try:
        yield
    finally:
        if root:
            os.seteuid(0)


@contextlib.contextmanager
def umask(mask: int) -> Iterator[None]:
    before = os.umask(mask)
    try:
        yield
    finally:
        os.umask(before)


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_writes_text_and_bytes(tmp_path: Path) -> None:
    write_text_atomic(tmp_path / "a", "grün\n")
    write_bytes_atomic(str(tmp_path / "b"), b"\x00")
    assert (tmp_path / "a").read_bytes() == "grün\n".encode()
    assert (tmp_path / "b").read_bytes() == b"\x00"
    assert names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_a_new_file_gets_the_mode_of_the_umask(tmp_path: Path, mask: int, mode: int) -> None:
    with umask(mask):
        write_text_atomic(tmp_path / "a", "x")
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == mode


def test_an_old_file_keeps_its_mode(tmp_path: Path) -> None:
    target = tmp_path / "a"
    target.write_text("old")
    target.chmod(0o640)
    write_text_atomic(target, "new")
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_a_link_keeps_pointing(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write_text_atomic(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_a_pipe_is_written_to_directly(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    got: list[str] = []
    reader = threading.Thread(target=lambda: got.append((tmp_path / "pipe").read_text()))
    reader.start()
    write_text_atomic(tmp_path / "pipe", "hello")
    reader.join(5)
    assert got == ["hello"]
    assert names(tmp_path) == ["pipe"]


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize(
    "fault", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()]
)
def test_nothing_half_written_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, fault: BaseException
) -> None:
    target = tmp_path / "plan.json"
    target.write_text("old")

    def fail(*_: object) -> None:
        raise fault

    monkeypatch.setattr(os if step == "fsync" else Path, step, fail)
    expected = InputError if isinstance(fault, OSError) else KeyboardInterrupt
    with pytest.raises(expected) as caught:
        write_text_atomic(target, "new")
    assert target.read_text() == "old"
    assert names(tmp_path) == ["plan.json"]
    if isinstance(fault, OSError):
        assert str(caught.value) == (
            f"cannot write {str(target)!r}: No space left on device; "
            "free some space, or choose another place"
        )


def test_unwritable_places(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*; create the folder .*none' first"):
        write_text_atomic(tmp_path / "none" / "a", "x")
    with pytest.raises(InputError, match=r"Is a directory; give the path of a file"):
        write_text_atomic(tmp_path, "x")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"Not a directory; check the path"):
        write_text_atomic(tmp_path / "file" / "a", "x")
    with pytest.raises(InputError, match=r"cannot write .*; "):
        write_text_atomic(tmp_path / "a\0b", "x")
    with pytest.raises(InputError, match=r"File name too long; choose a shorter name"):
        write_text_atomic(tmp_path / ("a" * 300), "x")


def test_no_permission_to_write(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "a").chmod(0o444)
    tmp_path.chmod(0o555)
    try:
        with unprivileged(), pytest.raises(InputError, match=r"Permission denied; check the perm"):
            write_text_atomic(tmp_path / "a", "new")
        with unprivileged(), pytest.raises(InputError, match=r"Permission denied; check the perm"):
            write_text_atomic(tmp_path / "b", "new")
    finally:
        tmp_path.chmod(0o755)
    assert names(tmp_path) == ["a"]
    assert (tmp_path / "a").read_text() == "old"


def test_no_permission_to_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("x")
    (tmp_path / "a").chmod(0)
    with unprivileged(), pytest.raises(InputError, match=r"cannot read .*Permission denied; check"):
        read_text(tmp_path / "a")


def test_reads_with_and_without_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbfgr\xc3\xbcn")
    assert read_text(tmp_path / "a") == "grün"


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "is empty"),
        (b" \n", "is empty"),
        (b"\xef\xbb\xbf", "is empty"),
        ("{}".encode("utf-16"), "is UTF-16 text; save it as UTF-8"),
        ("{}".encode("utf-16-le"), "is binary, not text"),
        (b"\x7fELF\0\0\xff", "is binary, not text"),
        (b"{\xff}", r"is not UTF-8 text \(byte 1, line 1\); save it as UTF-8"),
    ],
)
def test_what_is_no_text(tmp_path: Path, data: bytes, problem: str) -> None:
    (tmp_path / "a").write_bytes(data)
    with pytest.raises(InputError, match=problem):
        read_text(tmp_path / "a")


def test_old_encodings_are_read_on_request(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes("Köln".encode("latin-1"))
    assert read_text(tmp_path / "a", fallback="latin-1") == "Köln"


def test_what_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file or directory; check the path"):
        read_text(tmp_path / "none")
    with pytest.raises(InputError, match="Is a directory; give the path of a file"):
        read_text(tmp_path)
    os.mkfifo(tmp_path / "pipe")  # nobody writes to it: waiting would be for ever
    with pytest.raises(InputError, match="is not a regular file"):
        read_text(tmp_path / "pipe")
    with pytest.raises(InputError, match="is not a regular file"):
        read_text("/dev/zero")
    with pytest.raises(InputError, match="cannot read"):
        read_text("a\0b")
    with (tmp_path / "huge").open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(InputError, match="200 MB are more than"):
        read_text(tmp_path / "huge")
