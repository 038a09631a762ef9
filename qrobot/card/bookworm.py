"""Files of Raspberry Pi OS bookworm: custom.toml, and what other ways of a first boot read.

Who reads them: raspberrypi-sys-mods (``firstboot`` calls ``init_config`` with custom.toml, which
calls ``imager_custom``; ``sshswitch`` looks for ``ssh``) and userconf-pi (``userconf.txt``).
"""

from __future__ import annotations

import re
import uuid

from qrobot.card.quoting import keyfile_ssid, keyfile_text, quoted
from qrobot.card.seed import Seed, Wifi
from qrobot.errors import InputError

__all__ = ["NAMES", "files"]

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
    for value, option, advice in (
        (seed.address, "--static-address", "let the router reserve one"),
        (seed.locale, "--locale", "set it later with raspi-config"),
    ):
        if value is not None:
            raise InputError(
                "is not read by the first boot of bookworm",
                field=option,
                advice=f"leave it out: {advice}",
            )
    if seed.wifi is not None:
        _check_wifi(seed.wifi)
    texts = {"ssh": ""}
    if seed.password is not None:
        texts["userconf.txt"] = f"{seed.user}:{seed.password}\n"
    if seed.wifi is not None:
        texts[KEYFILE] = _keyfile(seed.wifi)
    texts["custom.toml"] = _toml(seed)
    return texts


def _check_wifi(wifi: Wifi) -> None:
    """Refuse what the first boot would write into its keyfile in another way."""
    if wifi.security == "wpa3":
        raise InputError(
            "is not known to the first boot of bookworm",
            field="--wifi-wpa3",
            advice="use --wifi-plain, which speaks WPA2 and WPA3",
        )
    # It copies a passphrase as it is, as an argument and into a keyfile, where these mean more.
    if wifi.security == "mixed" and re.search(r"^[- ]| $|\\", wifi.key):
        raise InputError(
            "has a backslash, or a space or hyphen at an end, which bookworm does not copy whole",
            field="--wifi-passphrase-file",
            advice="leave --wifi-plain out, or change the passphrase",
        )


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
            f"password_encrypted = {'true' if seed.wifi.security == 'wpa2' else 'false'}",
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
psk={keyfile_text(wifi.key)}

[ipv4]
method=auto

[ipv6]
method=auto
"""
