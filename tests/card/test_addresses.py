"""Static addresses: what is taken stands in netplan's own form, and nothing else is taken."""

from __future__ import annotations

import ipaddress
from typing import Any

import pytest
from card.made import seed
from hypothesis import assume, given
from hypothesis import strategies as st

from qrobot.card import StaticAddress, seed_files
from qrobot.errors import InputError

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

OWN = "10.0.0.5/24"


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (("192.168.1.20",), "--static-address"),
        (("192.168.1.0/24",), "whole network"),
        (("192.168.1.255/24",), "whole network"),
        (("2001:db8::/64",), "whole network"),
        (("127.0.0.1/8",), "not the address of one machine"),
        (("224.0.0.9/4",), "not the address of one machine"),
        (("255.255.255.255/32",), "not the address of one machine"),
        (("240.0.0.1/24",), "not the address of one machine"),
        (("0.0.0.0/24",), "not the address of one machine"),
        (("0.0.0.5/24",), "not the address of one machine"),
        (("::/64",), "not the address of one machine"),
        (("::1/128",), "not the address of one machine"),
        (("ff02::1/64",), "not the address of one machine"),
        (("::ffff:10.0.0.5/120",), "not the address of one machine"),
        (("fe80::20%eth0/64",), "not an address with a prefix"),
        (("10.0.0.5/0.0.0.255",), r"give 10\.0\.0\.5/24"),
        (("10.0.0.5/0.0.255.255",), r"give 10\.0\.0\.5/16"),
        (("10.0.0.5/255.0.255.0",), "not an address with a prefix"),
        (("10.0.0.5/0",), "prefix length of 0"),
        (("10.0.0.5/0.0.0.0",), "prefix length of 0"),
        (("2001:db8::20/0",), "prefix length of 0"),
        (("10.0.0.5/33",), "not an address with a prefix"),
        (("10.0.0.5/-1",), "not an address with a prefix"),
        (("10.0.0.5/",), "not an address with a prefix"),
        (("10.0.0.5/24/24",), "not an address with a prefix"),
        (("10.0.0.5/24 ",), "not an address with a prefix"),
        (("10.0.0.05/24",), "not an address with a prefix"),
        (("2001:db8::20/ffff::",), "not an address with a prefix"),
        (("192.168.1.300/24",), "--static-address"),
        (("robot/24",), "--static-address"),
        *(
            ((OWN, gateway), "--gateway")
            for gateway in [
                "10.0.0.255", "10.0.0.0", "10.0.1.1", "10.0.0.5", "fe80::1", "router", "",
                "224.0.0.1", "0.0.0.0", "255.255.255.255", "127.0.0.1", "169.254.0.1",
                "10.0.0.1/24",
            ]
        ),
        *(
            (("2001:db8::20/64", gateway), "--gateway")
            for gateway in [
                "2001:db8:1::1", "2001:db8::20", "2001:db8::", "fe80::1%eth0", "ff02::2", "::",
                "::1", "10.0.0.1", "::ffff:10.0.0.1",
            ]
        ),
        (("fe80::20/64", "fe80::20"), "--gateway"),
        (("128.0.0.1/1", "224.0.0.1"), "--gateway"),
        *(
            ((OWN, None, ("9.9.9.9", server)), "--dns")
            for server in [
                "dns", "", "224.0.0.1", "224.0.0.251", "255.255.255.255", "0.0.0.0", "0.0.0.1",
                "240.0.0.1", "127.0.0.1", "fe80::1%eth0", "ff02::fb", "::", "::1", "10.0.0.255",
                "10.0.0.0", "10.0.0.5", "::ffff:9.9.9.9", "9.9.9.9:53", "9.9.9.9/32", "09.9.9.9",
            ]
        ),
    ],
)  # fmt: skip
def test_addresses_that_are_refused(values: tuple[Any, ...], says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        StaticAddress(*values)
    assert ";" in str(refused.value), "no advice"


@pytest.mark.parametrize(
    ("values", "kept"),
    [
        (("10.0.0.5/255.255.255.0", "10.0.0.1"), ("10.0.0.5/24", "10.0.0.1", ())),
        (("10.0.0.5/255.255.255.255",), ("10.0.0.5/32", None, ())),
        (("10.0.0.5/024",), ("10.0.0.5/24", None, ())),
        (("169.254.7.7/16",), ("169.254.7.7/16", None, ())),
        (("10.0.0.1/31", "10.0.0.0"), ("10.0.0.1/31", "10.0.0.0", ())),
        (("fd00::20/64", "fd00::1", ("fd00::1",)), ("fd00::20/64", "fd00::1", ("fd00::1",))),
        (("2001:db8::20/64", "fe80::1"), ("2001:db8::20/64", "fe80::1", ())),
        (("2001:0DB8:0:0::20/64", "FE80:0::1"), ("2001:db8::20/64", "fe80::1", ())),
        (("2001:db8::1/127", "2001:db8::"), ("2001:db8::1/127", "2001:db8::", ())),
        (
            (OWN, None, ("9.9.9.9", "2620:FE::fe", "9.9.9.9", "10.0.0.1", "64:ff9b::909:909")),
            (OWN, None, ("9.9.9.9", "2620:fe::fe", "10.0.0.1", "64:ff9b::909:909")),
        ),
    ],
)
def test_addresses_that_are_taken(
    values: tuple[Any, ...], kept: tuple[str, str | None, tuple[str, ...]]
) -> None:
    found = StaticAddress(*values)
    assert (found.address, found.gateway, found.dns) == kept


@given(
    st.ip_addresses(v=4) | st.ip_addresses(v=6),
    st.integers(0, 128),
    st.booleans(),
    st.none() | st.ip_addresses(v=4) | st.ip_addresses(v=6) | st.just("fe80::1"),
    st.lists(st.ip_addresses(), max_size=3),
)
def test_what_is_written_is_what_netplan_parses(
    own: Any, prefix: int, as_mask: bool, gateway: Any, dns: list[Any]
) -> None:
    """netplan splits at the slash, reads a number of 1 to 32 or 128, and inet_pton the rest."""
    assume(prefix <= own.max_prefixlen)
    network = ipaddress.ip_network((own, prefix), strict=False)
    mask = network.netmask if as_mask and own.version == 4 else prefix
    try:
        address = StaticAddress(
            f"{own}/{mask}", None if gateway is None else str(gateway), tuple(map(str, dns))
        )
    except InputError:
        return
    text = seed_files(seed(address=address))["network-config"]
    card = yaml.safe_load(text)["network"]["ethernets"]["eth0"]
    ((written, _, length),) = [one.partition("/") for one in card["addresses"]]
    assert ipaddress.ip_address(written) == own
    assert length == str(prefix)
    assert prefix >= 1
    for route in card.get("routes", []):
        router = ipaddress.ip_address(route["via"])
        assert router == ipaddress.ip_address(str(gateway))
        assert router in network or (router.version == 6 == own.version and router.is_link_local)
        assert router != own
        assert route["to"] == ("::/0" if own.version == 6 else "0.0.0.0/0")
    servers = card.get("nameservers", {}).get("addresses", [])
    assert servers == list(dict.fromkeys(map(str, dns)))
    assert not any(s.is_multicast or s.is_unspecified or s.is_loopback for s in dns)
