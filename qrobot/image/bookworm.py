"""Files of Raspberry Pi OS bookworm: custom.toml, and what other ways of a first boot read.

Who reads them: raspberrypi-sys-mods (``firstboot`` calls ``init_config`` with custom.toml, which
calls ``imager_custom``; ``sshswitch`` looks for ``ssh``) and userconf-pi (``userconf.txt``).
"""

from __future__ import annotations

import uuid

from qrobot.errors import InputError
from qrobot.image.model import Seed, Wifi
from qrobot.image.quoting import keyfile_ssid, quoted

__all__ = ["KEYFILE", "NAMES", "files"]

KEYFILE = "qrobot-wifi.nmconnection"
NAMES = ("ssh", "userconf.txt", KEYFILE, "custom.toml")
"""All files that a seed may consist of."""
LOCKED = "!"
"""The hash of no password at all: what ``init_config`` itself takes for one that is missing."""


def files(seed: Seed) -> dict[str, str]:
    """Return the files, the one that the first boot acts on last.

    Raises
    ------
    InputError
        When the seed holds what this release's first boot does not read.
    """
    for value, option, mend in (
        (seed.address, "--static-address", "let the router reserve one"),
        (seed.locale, "--locale", "set it later with raspi-config"),
    ):
        if value is not None:
            raise InputError(
                "is not read by the first boot of bookworm",
                field=option,
                mend=f"leave it out: {mend}",
            )
    texts = {"ssh": ""}
    if seed.password is not None:
        texts["userconf.txt"] = f"{seed.user}:{seed.password}\n"
    if seed.wifi is not None:
        texts[KEYFILE] = _keyfile(seed.wifi)
    texts["custom.toml"] = _toml(seed)
    return texts


def _toml(seed: Seed) -> str:
    keys = ", ".join(quoted(key) for key in seed.keys)
    lines = [
        "# Written by: qrobot image seed",
        "config_version = 1",
        "",
        "[system]",
        f"hostname = {quoted(seed.hostname)}",
        "",
        "[user]",
        f"name = {quoted(seed.user)}",
        f"password = {quoted(seed.password or LOCKED)}",
        "password_encrypted = true",
        "",
        "[ssh]",
        "enabled = true",
        "password_authentication = false",
        f"authorized_keys = [{keys}]",
    ]
    if seed.wifi:
        # The reader puts the name into a keyfile as it is: it must be escaped for that one.
        lines += [
            "",
            "[wlan]",
            f"ssid = {quoted(keyfile_ssid(seed.wifi.ssid))}",
            f"password = {quoted(seed.wifi.key)}",
            "password_encrypted = true",
            f"hidden = {'true' if seed.wifi.hidden else 'false'}",
            f"country = {quoted(seed.wifi.country)}",
        ]
    if seed.keyboard or seed.timezone:
        lines += ["", "[locale]"]
    if seed.keyboard:
        lines.append(f"keymap = {quoted(seed.keyboard)}")
    if seed.timezone:
        lines.append(f"timezone = {quoted(seed.timezone)}")
    return "\n".join([*lines, ""])


def _keyfile(wifi: Wifi) -> str:
    ssid = keyfile_ssid(wifi.ssid)
    identity = uuid.uuid5(uuid.NAMESPACE_OID, f"qrobot-wifi {ssid}")
    return f"""\
# Written by: qrobot image seed
[connection]
id=qrobot-wifi
uuid={identity}
type=wifi

[wifi]
mode=infrastructure
ssid={ssid}
hidden={"true" if wifi.hidden else "false"}

[wifi-security]
key-mgmt=wpa-psk
psk={wifi.key}

[ipv4]
method=auto

[ipv6]
method=auto
"""
