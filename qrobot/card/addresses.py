"""A static address: checked as netplan and NetworkManager would, long before a robot is deaf.

netplan refuses the whole file for one address that it does not take, and a robot without a screen
then has no network at all; what it takes is written into one form, IP/PREFIX.
"""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass

from qrobot.errors import InputError

__all__ = ["StaticAddress"]

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Interface = ipaddress.IPv4Interface | ipaddress.IPv6Interface

_EXAMPLE = "give one such as 192.168.1.20/24"
_THIS_NETWORK = ipaddress.IPv4Network("0.0.0.0/8")


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


def _refused(value: str, field: str, problem: str, advice: str) -> InputError:
    return InputError(f"{value!a} {problem}", field=field, advice=advice)
