"""Public keys: real ones of ssh-keygen are taken, everything else is refused."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from card.made import KEY, OTHER_KEY, line
from hypothesis import given
from hypothesis import strategies as st

from qrobot.card import public_keys
from qrobot.errors import InputError


def made(folder: Path, *words: str) -> Path:
    if not shutil.which("ssh-keygen"):
        pytest.skip("ssh-keygen is not here")
    path = folder / "key"
    subprocess.run(["ssh-keygen", "-q", "-N", "", "-f", path, *words], check=True)
    return path


@pytest.mark.parametrize(
    "words",
    [
        ["-t", "ed25519"],
        ["-t", "rsa", "-b", "2048"],
        *(["-t", "ecdsa", "-b", bits] for bits in ("256", "384", "521")),
    ],
    ids=" ".join,
)
def test_keys_of_ssh_keygen(words: list[str], tmp_path: Path) -> None:
    path = made(tmp_path, *words, "-C", "mira@desk")
    text = path.with_suffix(".pub").read_text()
    assert public_keys(text, "key.pub") == [text.strip()]


def test_a_weak_key_is_refused(tmp_path: Path) -> None:
    text = made(tmp_path, "-t", "rsa", "-b", "1024").with_suffix(".pub").read_text()
    with pytest.raises(InputError, match="RSA key of 1024 bits, which is weak"):
        public_keys(text, "key.pub")


@pytest.mark.parametrize("form", ["RFC4716", "PEM", "PKCS8"])
def test_a_private_key_is_refused_and_not_told(form: str, tmp_path: Path) -> None:
    text = made(tmp_path, "-t", "rsa", "-b", "2048", "-m", form).read_text()
    with pytest.raises(InputError, match="private key") as refused:
        public_keys(text, "key")
    assert all(row not in str(refused.value) for row in text.splitlines() if row)


def test_keys_of_security_keys() -> None:
    for text in (
        line("sk-ssh-ed25519@openssh.com", bytes(32), b"ssh:"),
        line("sk-ecdsa-sha2-nistp256@openssh.com", b"nistp256", b"\4" + bytes(64), b"ssh:"),
    ):
        assert public_keys(text, "x") == [text]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no key"),
        ("# only a comment\n\n", "holds no key"),
        (line("ssh-dss", b"1", b"2", b"3", b"4"), "DSA"),
        (line("ssh-ed25519", bytes(31)), "damaged"),
        (line("ssh-ed25519", bytes(32), b"more"), "damaged"),
        (line("ssh-rsa", b"\1\0\1"), "damaged"),
        (line("ecdsa-sha2-nistp256", b"nistp384", bytes(65)), "damaged"),
        (line("sk-ssh-ed25519@openssh.com", bytes(32)), "damaged"),
        (line("ssh-unheard", b"x"), "unknown type"),
        (line("nistp256", b"nistp256", bytes(65)), "unknown type"),
        (line("sk-ssh-rsa@openssh.com", b"\1\0\1", b"\xff" * 256, b"ssh:"), "unknown type"),
        (line("ssh-rsa", bytes(32)).replace("ssh-rsa", "ssh-ed25519"), "not a public key"),
        (KEY[:40], "not a public key"),
        ("ssh-ed25519 not*base64", "not a public key"),
        (f'command="x" {KEY}', "not a public key"),
        ("hello", "not a public key"),
        ("---- BEGIN SSH2 PUBLIC KEY ----\nAAAA\n", "ssh-keygen -i"),
        ("PuTTY-User-Key-File-3: ssh-ed25519\n", "private key"),
    ],
)
def test_what_is_no_key(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        public_keys(text, "key.pub")
    assert "key.pub: --key: " in str(refused.value)
    assert "AAAA" not in str(refused.value)


def test_a_file_of_several_keys() -> None:
    text = f"# mine\n{KEY}\r\n\n  {OTHER_KEY}  \n{KEY}\n"
    assert public_keys(text, "x") == [KEY, OTHER_KEY]


@given(st.text())
def test_a_comment_carries_nothing(comment: str) -> None:
    comment = " ".join(comment.split())
    bare = KEY.rsplit(" ", 1)[0]
    try:
        (key,) = public_keys(f"{bare} {comment}", "x")
    except InputError:  # a comment of several lines
        assert len(comment.splitlines()) > 1 or "PRIVATE KEY" in comment
        return
    assert key.startswith(bare)
    assert key.isascii()
    assert key.isprintable()
    assert not set(key) & set("\"'\\#`$")
