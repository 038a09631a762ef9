"""What a robot's first boot is told; a value that no first boot would take cannot be made."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass

from qrobot.errors import InputError
from qrobot.image import checks

__all__ = ["Seed", "StaticAddress", "Wifi"]


@dataclass(frozen=True)
class Wifi:
    """A Wi-Fi to join.

    Parameters
    ----------
    ssid
        Name of the network, 1 to 32 bytes of UTF-8.
    key
        64 hexadecimal digits, as `wifi_key` derives them.
    country
        Where the robot works (ISO 3166): it decides which channels may be used.
    hidden
        The network does not tell its name.

    Raises
    ------
    InputError
        When a value has another form.
    """

    ssid: str
    key: str
    country: str
    hidden: bool = False

    def __post_init__(self) -> None:
        checks.ssid(self.ssid)
        object.__setattr__(self, "country", checks.country_code(self.country))
        if not re.fullmatch(r"[0-9a-f]{64}", self.key):
            raise InputError("is no derived key", field="key", mend="derive it with wifi_key()")

    def __repr__(self) -> str:
        return f"Wifi({self.ssid!r}, country={self.country!r}, hidden={self.hidden})"


@dataclass(frozen=True)
class StaticAddress:
    """An address that does not come from the network's DHCP server.

    Parameters
    ----------
    address
        With the length of the network's prefix: ``192.168.1.20/24`` or of IPv6.
    gateway
        The router, in the same network; none where the robot stays inside.
    dns
        Name servers.

    Raises
    ------
    InputError
        When a text is no such address, or the router is out of reach.
    """

    address: str
    gateway: str | None = None
    dns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        try:
            own = ipaddress.ip_interface(self.address)
            if "/" not in self.address:
                raise ValueError
        except ValueError:
            raise InputError(
                f"{self.address!a} is no address with a prefix",
                field="--static-address",
                mend="give one such as 192.168.1.20/24",
            ) from None
        # A prefix of 31 or 32 (127, 128) has no address of the network itself.
        ends = []
        if own.network.num_addresses > 2:
            ends = [own.network.network_address]
            ends += [own.network.broadcast_address] if own.version == 4 else []
        if own.is_loopback or own.is_multicast or own.is_unspecified:
            raise InputError(
                f"{self.address!a} is no address of one machine on a network",
                field="--static-address",
                mend="give one such as 192.168.1.20/24",
            )
        if own.ip in ends:
            raise InputError(
                f"{self.address!a} is the address of a whole network",
                field="--static-address",
                mend="give the one of the robot",
            )
        for option, text in [("--gateway", self.gateway), *(("--dns", one) for one in self.dns)]:
            if text is None:
                continue
            try:
                other = ipaddress.ip_address(text)
            except ValueError:
                raise InputError(
                    f"{text!a} is no address", field=option, mend="give one such as 192.168.1.1"
                ) from None
            if option == "--gateway" and (
                other not in own.network or other == own.ip or other in ends
            ):
                raise InputError(
                    f"{text!a} is no other machine of the network {own.network}",
                    field=option,
                    mend="give the address of the router",
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
            raise InputError("is no hash", field="password", mend="make one with password_hash()")
        if self.timezone is not None:
            checks.time_zone(self.timezone)
        if self.locale is not None:
            checks.locale_name(self.locale)
        if self.keyboard is not None:
            checks.keyboard(self.keyboard)

    def __repr__(self) -> str:
        return f"Seed({self.hostname!r}, {self.user!r}, {len(self.keys)} keys)"
