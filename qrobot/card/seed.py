"""What a robot's first boot is told; a value that no first boot would take cannot be made.

A static address is checked as netplan and NetworkManager would: netplan refuses the whole file for
one address that it does not take, and a robot without a screen then has no network at all.
"""

from __future__ import annotations

import ipaddress
import re
import zoneinfo
from dataclasses import dataclass
from typing import Literal

from qrobot.card.secrets import checked_passphrase
from qrobot.errors import InputError

__all__ = ["Security", "Seed", "StaticAddress", "Wifi"]

_ISO_3166 = (
    "AD AE AF AG AI AL AM AO AQ AR AS AT AU AW AX AZ BA BB BD BE BF BG BH BI BJ BL BM BN BO BQ BR "
    "BS BT BV BW BY BZ CA CC CD CF CG CH CI CK CL CM CN CO CR CU CV CW CX CY CZ DE DJ DK DM DO DZ "
    "EC EE EG EH ER ES ET FI FJ FK FM FO FR GA GB GD GE GF GG GH GI GL GM GN GP GQ GR GS GT GU GW "
    "GY HK HM HN HR HT HU ID IE IL IM IN IO IQ IR IS IT JE JM JO JP KE KG KH KI KM KN KP KR KW KY "
    "KZ LA LB LC LI LK LR LS LT LU LV LY MA MC MD ME MF MG MH MK ML MM MN MO MP MQ MR MS MT MU MV "
    "MW MX MY MZ NA NC NE NF NG NI NL NO NP NR NU NZ OM PA PE PF PG PH PK PL PM PN PR PS PT PW PY "
    "QA RE RO RS RU RW SA SB SC SD SE SG SH SI SJ SK SL SM SN SO SR SS ST SV SX SY SZ TC TD TF TG "
    "TH TJ TK TL TM TN TO TR TT TV TW TZ UA UG UM US UY UZ VA VC VE VG VI VN VU WF WS YE YT ZA ZM "
    "ZW"
)

# Accounts and groups that Debian, Raspberry Pi OS or the playbooks make themselves.
_TAKEN = (
    "root daemon bin sys sync games man lp mail news uucp proxy www-data backup list irc nobody "
    "adm tty disk kmem dialout fax voice cdrom floppy tape sudo audio dip operator src shadow utmp "
    "video sasl plugdev staff users nogroup input kvm render crontab netdev gpio i2c spi lpadmin "
    "sshd messagebus avahi polkitd lightdm dnsmasq pulse rtkit ssh ssl-cert docker "
    "rpi-first-boot-wizard qrobot"
)


Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Interface = ipaddress.IPv4Interface | ipaddress.IPv6Interface

_EXAMPLE = "give one such as 192.168.1.20/24"
_THIS_NETWORK = ipaddress.IPv4Network("0.0.0.0/8")

_FORMS = {
    "--hostname": (
        r"[A-Za-z0-9]([A-Za-z0-9-]{0,61}[A-Za-z0-9])?",  # RFC 1123, one label
        "is not a host name",
        "give 1 to 63 letters, digits and hyphens, with no hyphen at either end",
    ),
    "--user": (
        r"[a-z][a-z0-9-]{0,31}",  # as the first boot of both releases takes it
        "is not a name that Raspberry Pi OS takes",
        "give up to 32 small letters, digits and hyphens, beginning with a letter",
    ),
    "--locale": (
        r"(C|[a-z]{2,3}_[A-Z]{2})\.UTF-8(@[a-z]+)?",
        "is not a locale of UTF-8",
        "give one such as de_DE.UTF-8 or C.UTF-8",
    ),
    "--keyboard": (r"[a-z]{2,12}", "is not a layout", "give one such as de, gb or us"),  # as in XKB
}
"""Of values that have a form: the form, what is wrong with another text, and the advice."""


def _check_form(option: str, text: str | None) -> None:
    form, problem, advice = _FORMS[option]
    if text is not None and not re.fullmatch(form, text):
        raise _refused(text, option, problem, advice)


def _check_host_name(text: str) -> None:
    if "." in text:
        raise _refused(text, "--hostname", "has a dot", "give the first part only")
    _check_form("--hostname", text)
    if text.lower() == "localhost" or text.isdigit():
        raise _refused(text, "--hostname", "would be taken for another machine", "give a name")


def _check_user_name(text: str) -> None:
    _check_form("--user", text)
    if text in _TAKEN.split():
        raise _refused(text, "--user", "is an account or group of the system", "give another name")


def _country_code(text: str) -> str:
    """Return the code of a country (ISO 3166), in capitals."""
    code = text.upper()
    if code not in _ISO_3166.split():
        advice = "give GB" if code == "UK" else "give the two letters of ISO 3166, such as DE"
        raise _refused(text, "--wifi-country", "is not the code of a country", advice)
    return code


def _check_ssid(text: str) -> None:
    try:
        size = len(text.encode())
    except UnicodeEncodeError:  # bytes of an argument that are not UTF-8
        size = 0
    if not 1 <= size <= 32 or "\0" in text:
        raise _refused(
            text,
            "--wifi-ssid",
            "is not the name of a Wi-Fi",
            "give 1 to 32 bytes of UTF-8 without NUL",
        )


def _check_time_zone(text: str) -> None:
    """Refuse what is not a time zone; without a list of them only the form is checked."""
    known = zoneinfo.available_timezones()
    form = re.fullmatch(r"[A-Za-z][A-Za-z0-9_+-]*(/[A-Za-z0-9_+-]+){0,2}", text)
    # Debian's list has two that are none: a link to the machine's own, and a placeholder.
    if not form or text in ("localtime", "Factory") or (known and text not in known):
        raise _refused(text, "--timezone", "is not a time zone", "give one such as Europe/Berlin")


def _refused(value: str, field: str, problem: str, advice: str) -> InputError:
    return InputError(f"{value!a} {problem}", field=field, advice=advice)


@dataclass(frozen=True)
class StaticAddress:
    """An address that does not come from the network's DHCP server.

    Every value is kept as netplan takes it: ``192.168.1.20/24``, also where the network's mask
    was given, and IPv6 in its short form.

    Parameters
    ----------
    address
        With the length of the network's prefix: ``192.168.1.20/24`` or of IPv6. A mask such as
        ``/255.255.255.0`` is turned into a length.
    gateway
        The router, in the same network or, in IPv6, by its link-local address; none where the
        robot stays inside.
    dns
        Name servers.

    Raises
    ------
    InputError
        When a text is not such an address, or the router is out of reach.
    """

    address: str
    gateway: str | None = None
    dns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        own = _interface(self.address)
        gateway = None if self.gateway is None else str(_gateway(self.gateway, own))
        dns = tuple(dict.fromkeys(str(_name_server(text, own)) for text in self.dns))
        object.__setattr__(self, "address", own.with_prefixlen)
        object.__setattr__(self, "gateway", gateway)
        object.__setattr__(self, "dns", dns)


def _interface(text: str) -> Interface:
    """Return the robot's own address with its network."""
    option = "--static-address"
    _, slash, mask = text.partition("/")
    try:
        own = ipaddress.ip_interface(text)
    except ValueError:
        slash = ""
    if not slash or "%" in text:
        raise _refused(text, option, "is not an address with a prefix length", _EXAMPLE)
    if "." in mask and ipaddress.IPv4Address(mask) != own.netmask:
        problem = "has a mask that is turned round"
        raise _refused(text, option, problem, f"give {own.ip}/{own.network.prefixlen}")
    if own.network.prefixlen == 0:
        raise _refused(text, option, "has a prefix length of 0", _EXAMPLE)
    if not _is_machine(own.ip):
        raise _refused(text, option, "is not the address of one machine on a network", _EXAMPLE)
    if own.ip in _ends(own):
        problem = f"is the address of the whole network {own.network}"
        raise _refused(text, option, problem, "give the one of the robot")
    return own


def _gateway(text: str, own: Interface) -> Address:
    """Return the router's address; in IPv6 routers are usually known by their link-local one."""
    option = "--gateway"
    gateway = _address(text, option)
    near = gateway in own.network or (gateway.version == 6 and gateway.is_link_local)
    if (
        gateway.version != own.version
        or not (near and _is_machine(gateway))
        or gateway == own.ip
        or gateway in _ends(own)
    ):
        problem = f"is not another machine of the network {own.network}"
        raise _refused(text, option, problem, "give the address of the router")
    return gateway


def _name_server(text: str, own: Interface) -> Address:
    option = "--dns"
    server = _address(text, option)
    if not _is_machine(server) or server in _ends(own):
        advice = "give the one of a name server, such as 9.9.9.9"
        raise _refused(text, option, "is not the address of one machine on a network", advice)
    if server == own.ip:
        advice = "give the one of a name server, such as 9.9.9.9"
        raise _refused(text, option, "is the robot itself, which has no name server", advice)
    return server


def _address(text: str, option: str) -> Address:
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        address = None
    if address is None or "%" in text:
        # A zone such as %eth0 is a name that only one machine knows: netplan takes none.
        problem = "has a zone" if address else "is not an address"
        raise _refused(text, option, problem, "give one such as 192.168.1.1")
    return address


def _is_machine(address: Address) -> bool:
    """Return whether one machine on a network can have an address."""
    if isinstance(address, ipaddress.IPv4Address):
        special = address.is_reserved or address in _THIS_NETWORK  # the broadcast is reserved
    else:
        special = address.ipv4_mapped is not None
    return not (special or address.is_loopback or address.is_multicast or address.is_unspecified)


def _ends(own: Interface) -> tuple[Address, ...]:
    """Return the addresses that mean the whole network; one of 1 or 2 addresses has none."""
    if own.network.num_addresses <= 2:
        return ()
    first, last = own.network.network_address, own.network.broadcast_address
    return (first, last) if own.version == 4 else (first,)


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
        _check_ssid(self.ssid)
        object.__setattr__(self, "country", _country_code(self.country))
        if self.security == "wpa2":
            if not re.fullmatch(r"[0-9a-f]{64}", self.key):
                raise InputError(
                    "is not a derived key", field="key", advice="derive it with wifi_key()"
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
        _check_host_name(self.hostname)
        _check_user_name(self.user)
        if not self.keys:
            raise InputError(
                "there is no key, and nobody could log in",
                field="--key",
                advice="give a public key",
            )
        if self.password is not None and not re.fullmatch(r"\$[!-9;-~]+", self.password):
            raise InputError(
                "is not a hash", field="password", advice="make one with password_hash()"
            )
        if self.timezone is not None:
            _check_time_zone(self.timezone)
        _check_form("--locale", self.locale)
        _check_form("--keyboard", self.keyboard)

    def __repr__(self) -> str:
        return f"Seed({self.hostname!r}, {self.user!r}, {len(self.keys)} keys)"
