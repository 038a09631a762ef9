"""Values as text of YAML, TOML and keyfiles, whatever characters they hold."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence

__all__ = ["Value", "keyfile_ssid", "keyfile_text", "netplan_ssid", "quoted", "yaml_text"]

Value = str | int | bool | Sequence["Value"] | Mapping[str, "Value"]
"""What `yaml_text` writes."""

_PLAIN_KEY = re.compile(r"(?!(y|n|yes|no|on|off|true|false|null)$)[a-z][a-z0-9_-]*")
_PLAIN_SSID = re.compile(r"[A-Za-z][A-Za-z0-9_.]*([ -][A-Za-z0-9_.]+)*")


def quoted(text: str) -> str:
    r"""Return a text in double quotes, as YAML and TOML both read it.

    Everything but printable ASCII is escaped. JSON's own escapes would not do: it writes a
    character beyond U+FFFF as two surrogates, which neither of the two puts together again.
    """
    return "".join(
        character
        if character < "\x7f"
        else f"\\u{ord(character):04x}"
        if ord(character) < 0x10000
        else f"\\U{ord(character):08x}"
        for character in json.dumps(text, ensure_ascii=False)
    )


def yaml_text(value: Mapping[str, Value]) -> str:
    """Return a mapping as YAML in block style, every text quoted; keys of 80 characters at most.

    YAML takes no longer key than 1024 characters, escapes included.
    """
    return "".join(f"{line}\n" for line in _lines(value))


def _lines(value: Value) -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            name = key if _PLAIN_KEY.fullmatch(key) else quoted(key)
            if _nested(inner):
                yield f"{name}:"
                yield from (f"  {line}" for line in _lines(inner))
            else:
                yield f"{name}: {_scalar(inner)}"
    elif isinstance(value, Sequence) and not isinstance(value, str):
        for inner in value:
            first, *rest = _lines(inner) if _nested(inner) else [_scalar(inner)]
            yield f"- {first}"
            yield from (f"  {line}" for line in rest)


def _nested(value: Value) -> bool:
    return isinstance(value, Mapping | Sequence) and not isinstance(value, str) and bool(value)


def _scalar(value: Value) -> str:
    if isinstance(value, str):
        return quoted(value)
    return json.dumps(value)  # true, 7, [] and {} are the same in YAML


def keyfile_ssid(ssid: str) -> str:
    """Return the name of a Wi-Fi as NetworkManager's keyfiles hold it.

    A name that is plain stands for itself. Any other is a list of its bytes (``104;105;``),
    the form that NetworkManager itself writes for what is not printable: nothing in it has to
    be escaped, and it cannot be taken for the option of a program that passes it on.
    """
    return ssid if _PLAIN_SSID.fullmatch(ssid) else _bytes_of(ssid)


def keyfile_text(text: str) -> str:
    r"""Return a text as GLib's keyfiles hold it: backslashes and the spaces at its ends escaped."""
    inner = text.strip(" ")
    before, _, after = text.partition(inner) if inner else (text, "", "")
    escaped = inner.replace("\\", "\\\\")
    return before.replace(" ", r"\s") + escaped + after.replace(" ", r"\s")


def netplan_ssid(ssid: str) -> str:
    """Return the name of a Wi-Fi as netplan hands it to NetworkManager unharmed.

    netplan escapes quotes, backslashes and control characters once too often for a keyfile, and
    digits with semicolons are a list of bytes there. Such names go as that list; NetworkManager
    reads it, networkd (which Raspberry Pi OS does not use) would not.
    """
    harmed = re.search(r"[\"\\\x00-\x1f\x7f-\x9f\u2028\u2029]|^\s|\s$|^[\s\d;]*$", ssid)
    return _bytes_of(ssid) if harmed else ssid


def _bytes_of(ssid: str) -> str:
    return "".join(f"{byte};" for byte in ssid.encode())
