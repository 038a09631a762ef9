"""What a robot's first boot is told; a value that no first boot would take cannot be made."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from qrobot.card import checks
from qrobot.card.addresses import StaticAddress
from qrobot.card.secrets import checked_passphrase
from qrobot.errors import InputError

__all__ = ["Security", "Seed", "StaticAddress", "Wifi"]


Security = Literal["wpa2", "mixed", "wpa3"]
"""How a robot proves that it may join a Wi-Fi."""


@dataclass(frozen=True)
class Wifi:
    """A Wi-Fi to join.

    Parameters
    ----------
    ssid
        Name of the network, 1 to 32 bytes of UTF-8.
    key
        For ``wpa2`` 64 hexadecimal digits, as `wifi_key` derives them; for the others the
        passphrase itself, 8 to 63 printable characters of ASCII.
    country
        Where the robot works (ISO 3166): it decides which channels may be used.
    hidden
        The network does not tell its name.
    security
        ``wpa2``: by the derived key (PSK); ``mixed``: by WPA2 or WPA3, as the access point likes;
        ``wpa3``: by WPA3 only. WPA3 (SAE) cannot be done with a derived key.

    Raises
    ------
    InputError
        When a value has another form.
    """

    ssid: str
    key: str
    country: str
    hidden: bool = False
    security: Security = "wpa2"

    def __post_init__(self) -> None:
        checks.ssid(self.ssid)
        object.__setattr__(self, "country", checks.country_code(self.country))
        if self.security == "wpa2":
            if not re.fullmatch(r"[0-9a-f]{64}", self.key):
                raise InputError(
                    "is not a derived key", field="key", mend="derive it with wifi_key()"
                )
        else:
            checked_passphrase(self.key, field="key")

    def __repr__(self) -> str:
        return (
            f"Wifi({self.ssid!r}, country={self.country!r}, hidden={self.hidden},"
            f" security={self.security!r})"
        )


@dataclass(frozen=True)
class Seed:
    """All that a first boot is told.

    Parameters
    ----------
    hostname
        Name of the machine, without a domain.
    user
        The account that logs in.
    keys
        Public keys of SSH that open it, as `public_keys` returns them.
    password
        Hash of its password, as `password_hash` returns it; none: only the keys open it.
    wifi
        The Wi-Fi to join; none: only the cable.
    timezone, locale, keyboard
        Such as ``Europe/Berlin``, ``de_DE.UTF-8`` and ``de``; none: as the image has it.
    address
        A static address, of the Wi-Fi where there is one, otherwise of the cable.

    Raises
    ------
    InputError
        When a value has another form; names the option of the command line.
    """

    hostname: str
    user: str
    keys: tuple[str, ...]
    password: str | None = None
    wifi: Wifi | None = None
    timezone: str | None = None
    locale: str | None = None
    keyboard: str | None = None
    address: StaticAddress | None = None

    def __post_init__(self) -> None:
        checks.host_name(self.hostname)
        checks.user_name(self.user)
        if not self.keys:
            raise InputError(
                "there is no key, and nobody could log in", field="--key", mend="give a public key"
            )
        if self.password is not None and not re.fullmatch(r"\$[!-9;-~]+", self.password):
            raise InputError(
                "is not a hash", field="password", mend="make one with password_hash()"
            )
        if self.timezone is not None:
            checks.time_zone(self.timezone)
        if self.locale is not None:
            checks.locale_name(self.locale)
        if self.keyboard is not None:
            checks.keyboard(self.keyboard)

    def __repr__(self) -> str:
        return f"Seed({self.hostname!r}, {self.user!r}, {len(self.keys)} keys)"
