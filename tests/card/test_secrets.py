"""Hashes and keys against other implementations; no secret in any sentence."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from typing import Any

import pytest

from qrobot.card import Wifi, password_hash, secrets, wifi_key
from qrobot.errors import BackendError, InputError


@pytest.mark.parametrize(
    ("ssid", "passphrase", "key"),
    [  # IEEE 802.11-2020, annex J.4.2
        ("IEEE", "password", "f42c6fc52df0ebef9ebb4b90b38a5f902e83fe1b135a70e23aed762e9710a12e"),
        (
            "ThisIsASSID",
            "ThisIsAPassword",
            "0dc0d6eb90555ed6419756b9a15ec3e3209b63df707dd508d14581f8982721af",
        ),
        (
            "Z" * 32,
            "a" * 32,
            "becb93866bb8c3832cb777c2f559807c8c59afcb6eae734885001300a981cc62",
        ),
    ],
)
def test_keys_of_the_standard(ssid: str, passphrase: str, key: str) -> None:
    assert wifi_key(ssid, passphrase) == key


def test_a_key_stays_a_key() -> None:
    assert wifi_key("x", "AB" * 32) == "ab" * 32


@pytest.mark.parametrize("passphrase", ["short-7", "x" * 64, "", "Pässwort-lang", "tab\tinside"])
def test_what_is_no_passphrase_is_refused_and_not_told(passphrase: str) -> None:
    with pytest.raises(InputError, match="8 to 63") as refused:
        wifi_key("x", passphrase, field="--wifi-passphrase-file")
    assert not passphrase or passphrase not in str(refused.value)
    assert "--wifi-passphrase-file" in str(refused.value)


def crypt(password: str, setting: str) -> str:
    """Another way to the machine's crypt(3)."""
    if not shutil.which("perl"):
        pytest.skip("perl, which verifies the hash, is not here")
    script = 'chomp(my ($p, $s) = <STDIN>); print crypt($p, $s) // "";'
    done = subprocess.run(
        ["perl", "-e", script], input=f"{password}\n{setting}\n", capture_output=True, check=True,
        text=True,
    )  # fmt: skip
    return done.stdout


def test_a_hash_opens_with_its_password_only() -> None:
    password = "correct horse, Pferd: größer"
    hashed = password_hash(password)
    assert crypt(password, hashed) == hashed
    assert crypt(password + "!", hashed) != hashed
    assert password_hash(password) != hashed, "no salt"
    assert password not in hashed


def test_openssl_is_the_second_way(monkeypatch: pytest.MonkeyPatch) -> None:
    if not shutil.which("openssl"):
        pytest.skip("openssl is not here")
    calls: list[list[str]] = []
    run = subprocess.run
    monkeypatch.setattr(secrets.ctypes, "CDLL", no_library)

    def seen(words: list[str], **options: Any) -> Any:
        calls.append(words)
        return run(words, **options)

    monkeypatch.setattr(secrets.subprocess, "run", seen)
    hashed = password_hash("correct horse")
    assert hashed.startswith("$6$")
    assert not any("correct" in word for words in calls for word in words)
    monkeypatch.undo()
    salt = hashed.split("$")[2]
    again = subprocess.run(
        ["openssl", "passwd", "-6", "-salt", salt, "correct horse"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert again.stdout.strip() == hashed
    assert crypt("correct horse", hashed) == hashed


def no_library(name: str) -> None:
    raise OSError(name)


def test_without_both_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(secrets.ctypes, "CDLL", no_library)
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(BackendError, match="install openssl") as refused:
        password_hash("correct horse")
    assert "correct" not in str(refused.value)


@pytest.mark.parametrize(
    "password", ["", "seven77", "x" * 201, "line\nbreak-long", "nul\0nul-long"]
)
def test_passwords_that_are_refused(password: str) -> None:
    with pytest.raises(InputError, match="8 to 200") as refused:
        password_hash(password)
    assert not password or password not in str(refused.value)


def test_a_key_shows_in_no_repr() -> None:
    key = hashlib.sha256(b"x").hexdigest()
    assert key not in repr(Wifi("x", key, "DE"))
