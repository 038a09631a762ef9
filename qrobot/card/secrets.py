"""What is written instead of secrets: hashes of passwords, derived keys of Wi-Fi."""

from __future__ import annotations

import ctypes
import hashlib
import re
import subprocess

from qrobot.errors import BackendError, InputError

__all__ = ["checked_passphrase", "password_hash", "wifi_key"]

SHORTEST = 8
"""Characters that a password must have at least."""

_HASH = re.compile(r"\$(y|6)\$[./0-9A-Za-z$]+")


def checked_passphrase(text: str, *, field: str = "passphrase") -> str:
    """Return a passphrase of WPA (IEEE 802.11-2020, annex J.4.1).

    Raises
    ------
    InputError
        When it has another form, or is a derived key, which cannot be turned back; its text is
        not told.
    """
    return _passphrase(text, field, "give 8 to 63 characters of ASCII")


def _passphrase(text: str, field: str, advice: str) -> str:
    if not (8 <= len(text) <= 63 and all(" " <= one <= "~" for one in text)):
        raise InputError("is not a passphrase of WPA", field=field, advice=advice)
    return text


def wifi_key(ssid: str, passphrase: str, *, field: str = "passphrase") -> str:
    """Return the key of a WPA network (the PSK), 64 hexadecimal digits.

    Parameters
    ----------
    ssid
        Name of the network, 1 to 32 bytes of UTF-8.
    passphrase
        8 to 63 printable ASCII characters; or the key itself, 64 hexadecimal digits.
    field
        What an error calls the passphrase.

    Raises
    ------
    InputError
        When the passphrase has another form; its text is not told.

    Notes
    -----
    PBKDF2 with HMAC-SHA1, 4096 rounds and the name as salt: IEEE 802.11-2020, annex J.4.
    """
    if re.fullmatch(r"[0-9A-Fa-f]{64}", passphrase):
        return passphrase.lower()
    _passphrase(passphrase, field, "give 8 to 63 characters of ASCII, or 64 hexadecimal digits")
    return hashlib.pbkdf2_hmac("sha1", passphrase.encode(), ssid.encode(), 4096, 32).hex()


def password_hash(password: str, *, field: str = "password") -> str:
    """Return the salted hash of a password, as ``/etc/shadow`` holds it.

    yescrypt (``$y$``) by the machine's libcrypt, which is what Debian itself uses; where that
    is absent SHA-512 (``$6$``) by the program openssl. Never the same twice.

    Raises
    ------
    InputError
        When the password is short, very long or holds what a keyboard does not.
    BackendError
        When neither libcrypt nor openssl is there.
    """
    if len(password) < SHORTEST or len(password.encode()) > 200 or not password.isprintable():
        raise InputError(
            "the password cannot be used",
            field=field,
            advice=f"give {SHORTEST} to 200 printable characters, or leave it out: "
            "the key is enough",
        )
    hashed = _yescrypt(password) or _sha512(password)
    if hashed is None or not _HASH.fullmatch(hashed):
        raise BackendError(
            "a password cannot be hashed here: neither libcrypt nor openssl does it;"
            " install openssl, or leave the password out: the key is enough"
        )
    return hashed


def _yescrypt(password: str) -> str | None:
    """Hash by libcrypt; Python's own way to it ended with 3.12."""
    for name in ("libcrypt.so.1", "libcrypt.so.2"):
        try:
            library = ctypes.CDLL(name)
            setting_of, crypt = library.crypt_gensalt_ra, library.crypt
        except (OSError, AttributeError):  # absent, or so old that it knows no yescrypt
            continue
        setting_of.restype, crypt.restype = ctypes.c_char_p, ctypes.c_char_p
        setting_of.argtypes = [ctypes.c_char_p, ctypes.c_ulong, ctypes.c_char_p, ctypes.c_int]
        crypt.argtypes = [ctypes.c_char_p, ctypes.c_char_p]
        setting: bytes | None = setting_of(b"$y$", 0, None, 0)
        hashed: bytes | None = crypt(password.encode(), setting) if setting else None
        if setting and hashed and hashed.startswith(setting):
            return hashed.decode("ascii")
    return None


def _sha512(password: str) -> str | None:
    """Hash by openssl, which gets the password by its input: arguments are seen by everybody."""
    try:
        done = subprocess.run(
            ["openssl", "passwd", "-6", "-stdin"],
            input=password + "\n",
            capture_output=True,
            encoding="utf-8",
            check=False,
        )
    except OSError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None
