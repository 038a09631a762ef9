"""Files of Raspberry Pi OS trixie: cloud-init with its data source NoCloud.

They hold only what every cloud-init knows, not the extensions of Raspberry Pi OS, so that a
plain Debian boots from them too. Read by cloud-init 25 (documentation: "NoCloud", "Module
reference", "Networking config Version 2") and, for the network, by netplan.
"""

from __future__ import annotations

import hashlib
import ipaddress

from qrobot.card.quoting import Value, netplan_ssid, yaml_text
from qrobot.card.seed import Seed, Wifi

__all__ = ["NAMES", "files"]

NAMES = ("user-data", "network-config", "meta-data")
"""All files that a seed consists of."""
_HEAD = "# Written by: qrobot image seed\n"
_GROUPS = (
    "adm", "audio", "dialout", "gpio", "i2c", "input", "netdev", "plugdev", "render", "spi", "sudo",
    "video",
)  # fmt: skip


def files(seed: Seed) -> dict[str, str]:
    """Return the three files; the one with the identity comes last.

    cloud-init does its work once for each identity. With this sequence a card that was pulled
    out too early never carries a new identity beside old files.
    """
    user = "#cloud-config\n" + _HEAD + yaml_text(_user_data(seed))
    network = _HEAD + yaml_text({"network": _network(seed)})
    identity = {"instance-id": instance_id(user + network), "dsmode": "local"}
    return {
        "user-data": user,
        "network-config": network,
        "meta-data": _HEAD + yaml_text(identity),
    }


def instance_id(text: str) -> str:
    """Return the identity of a seed: the same for the same text, another for another."""
    return f"qrobot-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _user_data(seed: Seed) -> dict[str, Value]:
    account: dict[str, Value] = {
        "name": seed.user,
        "groups": _GROUPS,
        "shell": "/bin/bash",
        "sudo": "ALL=(ALL) NOPASSWD:ALL",  # the playbooks ask for no password
        "lock_passwd": seed.password is None,
        "ssh_authorized_keys": seed.keys,
    }
    if seed.password is not None:
        account["hashed_passwd"] = seed.password  # `passwd` is ignored for an account that exists
    data: dict[str, Value] = {
        "hostname": seed.hostname,
        "manage_etc_hosts": True,
        "users": [account],
        "disable_root": True,
        "ssh_pwauth": False,
        "package_update": False,
        "package_upgrade": False,
    }
    if seed.timezone:
        data["timezone"] = seed.timezone
    if seed.locale:
        data["locale"] = seed.locale
    if seed.keyboard:
        data["keyboard"] = {"layout": seed.keyboard}
    # Raspberry Pi OS comes with sshd off. Not to wait for it: it may itself wait for us.
    commands: list[Value] = [["systemctl", "enable", "--now", "--no-block", "ssh"]]
    if seed.wifi:
        commands.append(["sh", "-c", _radio_on(seed.wifi.country)])
    data["runcmd"] = commands
    return data


def _radio_on(country: str) -> str:
    """Return what switches the radio on, which Raspberry Pi OS keeps off until it has a country.

    netplan hands a country to networkd only, and Raspberry Pi OS uses NetworkManager.
    """
    return (
        f"if command -v raspi-config; then raspi-config nonint do_wifi_country {country}; fi;"
        " if command -v rfkill; then rfkill unblock wifi; fi;"
        " if command -v nmcli; then nmcli radio wifi on; fi"
    )


def _network(seed: Seed) -> dict[str, Value]:
    cable: dict[str, Value] = {"dhcp4": True, "optional": True}
    network: dict[str, Value] = {"version": 2, "ethernets": {"eth0": cable}}
    static = cable
    if seed.wifi:
        point: dict[str, Value] = _secret(seed.wifi)
        if seed.wifi.hidden:
            point["hidden"] = True
        static = {
            "dhcp4": True,
            "optional": True,
            "regulatory-domain": seed.wifi.country,
            "access-points": {netplan_ssid(seed.wifi.ssid): point},
        }
        network["wifis"] = {"wlan0": static}
    if seed.address:
        static["dhcp4"] = False
        static["addresses"] = [seed.address.address]
        if seed.address.gateway:
            version = ipaddress.ip_address(seed.address.gateway).version
            everywhere = "0.0.0.0/0" if version == 4 else "::/0"
            static["routes"] = [{"to": everywhere, "via": seed.address.gateway}]
        if seed.address.dns:
            static["nameservers"] = {"addresses": seed.address.dns}
    return network


def _secret(wifi: Wifi) -> dict[str, Value]:
    """Return how an access point is joined.

    A password alone means WPA2 or WPA3 to netplan, and a derived key is of no use for WPA3: with
    one, the kind is told.
    """
    if wifi.security == "mixed":
        return {"password": wifi.key}
    management = "sae" if wifi.security == "wpa3" else "psk"
    return {"auth": {"key-management": management, "password": wifi.key}}
