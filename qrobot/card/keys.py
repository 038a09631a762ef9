"""Public keys of SSH: a line is taken apart before it is trusted to open a robot."""

from __future__ import annotations

import base64
import re

from qrobot.errors import InputError

__all__ = ["public_keys"]

WEAKEST_RSA = 2048
"""Bits that an RSA key must have at least."""

_POINTS = {"nistp256": 65, "nistp384": 97, "nistp521": 133}
_KINDS = {"ssh-ed25519", "ssh-rsa", *(f"ecdsa-sha2-{curve}" for curve in _POINTS)}
_ON_SECURITY_KEYS = {
    f"sk-{kind}@openssh.com": kind for kind in ("ssh-ed25519", "ecdsa-sha2-nistp256")
}
_MAKE = "make one with: ssh-keygen -t ed25519"


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
