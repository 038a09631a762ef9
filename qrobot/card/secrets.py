"""What opens a robot, and what is written instead of it.

Public keys of SSH are taken apart before they are trusted; passwords are hashed, and keys of Wi-Fi
are derived.
"""

from __future__ import annotations

import base64
import ctypes
import hashlib
import re
import subprocess

from qrobot.errors import BackendError, InputError

__all__ = ["checked_passphrase", "password_hash", "public_keys", "wifi_key"]

SHORTEST = 8
"""Characters that a password must have at least."""

WEAKEST_RSA = 2048
"""Bits that an RSA key must have at least."""

_POINTS = {"nistp256": 65, "nistp384": 97, "nistp521": 133}
_KINDS = {"ssh-ed25519", "ssh-rsa", *(f"ecdsa-sha2-{curve}" for curve in _POINTS)}
_ON_SECURITY_KEYS = {
    f"sk-{kind}@openssh.com": kind for kind in ("ssh-ed25519", "ecdsa-sha2-nistp256")
}
_MAKE = "make one with: ssh-keygen -t ed25519"

_HASH = re.compile(r"\$(y|6)\$[./0-9A-Za-z$]+")


def checked_passphrase(
    text: str, *, field: str = "passphrase", advice: str = "give 8 to 63 characters of ASCII"
) -> str:
    """Return a passphrase of WPA (IEEE 802.11-2020, annex J.4.1).

    Raises
    ------
    InputError
        When it has another form, or is a derived key, which cannot be turned back; its text is
        not told.
    """
    if not re.fullmatch(r"[ -~]{8,63}", text):
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
    advice = "give 8 to 63 characters of ASCII, or 64 hexadecimal digits"
    checked_passphrase(passphrase, field=field, advice=advice)
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


def public_keys(text: str, source: str) -> list[str]:
    """Return the public keys that a file holds, a line each.

    Parameters
    ----------
    text
        Lines as in ``id_ed25519.pub``; empty lines and comments are left out.
    source
        What an error calls the file.

    Raises
    ------
    InputError
        When there is no key, or one that is private, weak, damaged or of an unknown type.
        No error repeats what the file holds.
    """
    if re.search(r"PRIVATE KEY|PuTTY-User-Key-File", text):
        raise InputError(
            "holds a private key, which must never leave your machine",
            source=source,
            field="--key",
            advice="give the public one, whose file ends with .pub",
        )
    if "BEGIN SSH2 PUBLIC KEY" in text:
        raise InputError(
            "is a public key in another form",
            source=source,
            field="--key",
            advice="turn it into a line of OpenSSH with: ssh-keygen -i -f FILE",
        )
    lines = [line.strip() for line in text.splitlines()]
    keys = [_checked(line, source) for line in lines if line and not line.startswith("#")]
    if not keys:
        raise InputError("holds no key", source=source, field="--key", advice=_MAKE)
    return list(dict.fromkeys(keys))


def _checked(line: str, source: str) -> str:
    kind, _, rest = line.partition(" ")
    body, _, comment = rest.strip().partition(" ")
    try:
        fault = _fault(kind, base64.b64decode(body, validate=True))
    except ValueError:  # no base64, or cut off
        fault = "a line that is not a public key"
    if fault:
        raise InputError(f"holds {fault}", source=source, field="--key", advice=_MAKE)
    # The comment is not part of the key; what a first boot does with other characters is unknown.
    comment = re.sub(r"[^A-Za-z0-9._@+-]+", "_", comment.strip())[:80]
    return f"{kind} {body} {comment}".strip()


def _fault(kind: str, blob: bytes) -> str | None:
    """Return what is wrong with a key (RFC 4253, 5656, 8709), or None."""
    if kind == "ssh-dss":
        return "a DSA key, which servers refuse today"
    inside, *parts = _parts(blob)
    if inside != kind.encode():
        return "a line that is not a public key"
    if kind in _ON_SECURITY_KEYS:
        kind, parts = _ON_SECURITY_KEYS[kind], parts[:-1]  # the last is the application
    if kind not in _KINDS:
        return "a key of an unknown type"
    sizes = [len(part) for part in parts]
    if kind == "ssh-ed25519":
        return None if sizes == [32] else "a damaged key"
    if kind != "ssh-rsa":
        curve = kind.removeprefix("ecdsa-sha2-")
        fine = parts[:1] == [curve.encode()] and sizes[1:] == [_POINTS[curve]]
        return None if fine else "a damaged key"
    if len(parts) != 2:
        return "a damaged key"
    bits = int.from_bytes(parts[1], "big").bit_length()
    return f"an RSA key of {bits} bits, which is weak" if bits < WEAKEST_RSA else None


def _parts(blob: bytes) -> list[bytes]:
    """Take a key apart: texts, each behind its length in four bytes (RFC 4251)."""
    parts = []
    while blob:
        length = int.from_bytes(blob[:4], "big")
        if len(blob) < 4 + length:
            raise ValueError("cut off")
        parts.append(blob[4 : 4 + length])
        blob = blob[4 + length :]
    return parts or [b""]
