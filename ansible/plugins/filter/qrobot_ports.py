"""Ports that the packet filter lets in: what an inventory may write, as matches of nftables."""

from __future__ import annotations

import ipaddress
import re
from typing import Any

from ansible.errors import AnsibleFilterError

PORTS = re.compile(r"(\d+)(?:-(\d+))?(?:/(\w+))?", re.ASCII)
PROTOCOLS = ("tcp", "udp")
INTERFACE = re.compile(r"[A-Za-z0-9_.:@-]{1,15}", re.ASCII)
KEYS = ("port", "protocol", "source", "interface")
EXAMPLE = (
    'give 443, "53/udp", "8000-8010/tcp" or {port: 443, source: 192.168.1.0/24, interface: eth0}'
)


def rules(value: Any, name: str = "hardening_ports") -> list[dict[str, str]]:
    """Return what each port asks for: C(match), C(protocol) and C(ports), once each.

    Raises
    ------
    ValueError
        With one sentence for the first entry that cannot be used.
    """
    if not isinstance(value, list):
        raise ValueError(f"{name} is {value!r}: give a list, such as [443, 53/udp]")
    found: list[dict[str, str]] = []
    for at, entry in enumerate(value):
        try:
            new = list(_rules_of(entry))
        except ValueError as error:
            raise ValueError(f"{name}[{at}] is {entry!r}: {error}") from None
        found += [rule for rule in new if rule not in found]
    return found


def _rules_of(entry: Any) -> list[dict[str, str]]:
    if not isinstance(entry, dict):
        ports, protocol = _ports(entry, slash=True)
        return [{"match": "", "protocol": protocol or "tcp", "ports": ports}]
    unknown = [key for key in entry if key not in KEYS]
    if unknown:
        raise ValueError(f"{unknown[0]!r} is not known; the keys are {', '.join(KEYS)}")
    if "port" not in entry:
        raise ValueError("port is missing")
    ports, _ = _ports(entry["port"], slash=False)
    protocol = _protocol(entry.get("protocol", "tcp"))
    interface = entry.get("interface")
    match = ""
    if interface is not None:
        if not isinstance(interface, str) or not INTERFACE.fullmatch(interface):
            raise ValueError(f"interface {interface!r} is not a name such as eth0 or wlan0")
        match = f'iifname "{interface}" '
    sources = entry.get("source")
    if sources is None:
        return [{"match": match, "protocol": protocol, "ports": ports}]
    if sources == []:
        raise ValueError("source is empty, which nobody would match: leave it out, or name one")
    return [
        {"match": f"{match}{_source(one)} ", "protocol": protocol, "ports": ports}
        for one in (sources if isinstance(sources, list) else [sources])
    ]


def _ports(value: Any, slash: bool) -> tuple[str, str | None]:
    """Return a port or a range as nftables writes it, and the protocol behind the slash."""
    found = PORTS.fullmatch(str(value).strip()) if isinstance(value, (int, str)) else None
    if found is None or isinstance(value, bool) or (found[3] and not slash):
        raise ValueError(EXAMPLE)
    first, last = int(found[1]), int(found[2] or found[1])
    if not 1 <= first <= last <= 65535:
        what = "a range begins with its lower port" if first > last else "ports are 1 to 65535"
        raise ValueError(what)
    ports = str(first) if first == last else f"{first}-{last}"
    return ports, _protocol(found[3]) if found[3] else None


def _protocol(value: Any) -> str:
    if value not in PROTOCOLS:
        raise ValueError(f"protocol {value!r} is not known; use {' or '.join(PROTOCOLS)}")
    return str(value)


def _source(value: Any) -> str:
    """Return an address or a network as a match of nftables."""
    if not isinstance(value, str) or "%" in value:
        raise ValueError(f"source {value!r} is not an address or a network such as 192.168.1.0/24")
    try:
        network = ipaddress.ip_network(value)
    except ValueError:
        try:
            meant = ipaddress.ip_network(value, strict=False)
        except ValueError:
            raise ValueError(
                f"source {value!r} is not an address or a network such as 192.168.1.0/24"
            ) from None
        raise ValueError(f"source {value!r} names a host in a network: write {meant}") from None
    family = "ip" if network.version == 4 else "ip6"
    whole = network.prefixlen == network.max_prefixlen
    return f"{family} saddr {network.network_address if whole else network}"


def ports(value: Any) -> list[dict[str, str]]:
    """Return the matches of a list of ports."""
    try:
        return rules(value)
    except ValueError as error:
        raise AnsibleFilterError(str(error)) from None


def wrong(value: Any) -> str:
    """Return the sentence for the first entry that cannot be used; empty where all can."""
    try:
        rules(value)
    except ValueError as error:
        return str(error)
    return ""


class FilterModule:
    """The filters, by name."""

    def filters(self):
        return {"qrobot_ports": ports, "qrobot_ports_wrong": wrong}
