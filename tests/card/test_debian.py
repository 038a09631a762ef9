"""The files of trixie against Debian's own schemas and netplan, where they can be had."""

from __future__ import annotations

import configparser
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from card.debian import SCHEMAS, generator, unpacked
from card.made import HOSTILE, KEY, OTHER_KEY, name_of_keyfile, seed

from qrobot.card import Seed, StaticAddress, Wifi, seed_files, wifi_key
from qrobot.card.quoting import keyfile_text

jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

WIFI = Wifi("Warehouse", wifi_key("Warehouse", "Gabelstapler 7"), "DE", hidden=True)
MIXED = Wifi("Warehouse", r" Gabel#stapler; \s7", "DE", security="mixed", hidden=True)
ADDRESS = StaticAddress("192.168.1.20/24", "192.168.1.1", ("9.9.9.9",))
SEEDS = {
    "least": seed(),
    "most": seed(
        keys=(KEY, OTHER_KEY), password="$6$salt$" + "x" * 86, wifi=WIFI, timezone="Europe/Berlin",
        locale="de_DE.UTF-8", keyboard="de", address=ADDRESS,
    ),
    "address": seed(address=ADDRESS),
    "version 6": seed(address=StaticAddress("fd00::20/64", "fd00::1")),
    "version 6 by the link": seed(address=StaticAddress("2001:db8::20/64", "fe80::1")),
    "mask": seed(address=StaticAddress("10.0.0.5/255.255.255.0", "10.0.0.1")),
    "mixed": seed(wifi=MIXED),
}  # fmt: skip


@pytest.fixture(scope="module")
def debian(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = unpacked(tmp_path_factory.mktemp("debian"))
    if root is None:
        pytest.skip("no cloud-init here, and no apt to fetch it with")
    return root


def faults(schema: Path, value: Any) -> list[str]:
    if not schema.exists():
        pytest.skip(f"this cloud-init has no {schema.name}")
    validator = jsonschema.Draft4Validator(json.loads(schema.read_text()))
    return [error.message for error in validator.iter_errors(value)]


@pytest.mark.parametrize("name", SEEDS)
def test_user_data_fits_the_schema(name: str, debian: Path) -> None:
    schema = debian / SCHEMAS / "schema-cloud-config-v1.json"
    data = yaml.safe_load(seed_files(SEEDS[name])["user-data"])
    assert faults(schema, data) == []
    assert faults(schema, data | {"ssh_pwauth": ["perhaps"]}), "the schema takes anything"


@pytest.mark.parametrize("name", [name for name in SEEDS if SEEDS[name].wifi is None])
def test_the_network_fits_the_schema(name: str, debian: Path) -> None:
    # It knows no Wi-Fi: cloud-init hands that to netplan's own parser, as the next test does.
    schema = debian / SCHEMAS / "schema-network-config-v2.json"
    data = yaml.safe_load(seed_files(SEEDS[name])["network-config"])
    assert faults(schema, data) == []
    data["network"]["ethernets"]["eth0"]["dhcp4"] = "perhaps"
    assert faults(schema, data), "the schema takes anything"


def generated(debian: Path, folder: Path, told: Seed) -> configparser.ConfigParser:
    """Let netplan write NetworkManager's keyfiles, as Raspberry Pi OS has it do, and read one."""
    command = generator(debian)
    if command is None:
        pytest.skip("no netplan here")
    default = "network: {version: 2, renderer: NetworkManager}"
    settings = {
        "lib/netplan/00-network-manager-all.yaml": default,
        "etc/netplan/50-cloud-init.yaml": seed_files(told)["network-config"],
    }
    for name, text in settings.items():
        path = folder / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
        path.chmod(0o600)
    done = subprocess.run(
        [*command, "--root-dir", folder], capture_output=True, text=True, check=False
    )
    if "error while loading shared libraries" in done.stderr or "GLIBC" in done.stderr:
        pytest.skip(f"netplan does not run here: {done.stderr.strip()}")
    if "unknown key management type 'sae'" in done.stderr:
        pytest.skip("this netplan knows no WPA3: bookworm's, which reads no card of ours")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    (path,) = (folder / "run/NetworkManager/system-connections").glob(
        "netplan-wlan0*" if told.wifi else "netplan-eth0*"
    )
    keyfile = configparser.ConfigParser(interpolation=None)
    keyfile.read_string(path.read_text())
    return keyfile


@pytest.mark.parametrize("name", SEEDS)
def test_netplan_takes_the_network(name: str, debian: Path, tmp_path: Path) -> None:
    told = SEEDS[name]
    keyfile = generated(debian, tmp_path, told)
    if told.wifi:
        assert keyfile["wifi"]["ssid"] == "Warehouse"
        assert keyfile["wifi"]["hidden"] == "true"
        assert keyfile["wifi-security"]["key-mgmt"] == "wpa-psk"
        assert keyfile["wifi-security"]["psk"] == keyfile_text(told.wifi.key)
    version = "ipv6" if name.startswith("version 6") else "ipv4"
    assert keyfile[version]["method"] == ("manual" if told.address else "auto")
    if told.address:
        assert keyfile[version]["address1"].split(",")[0] == told.address.address
        assert str(told.address.gateway) in ",".join(keyfile[version].values())


def test_netplan_takes_wpa3(debian: Path, tmp_path: Path) -> None:
    wifi = Wifi("Warehouse", "Gabelstapler 7", "DE", security="wpa3")
    keyfile = generated(debian, tmp_path, seed(wifi=wifi))
    assert dict(keyfile["wifi-security"]).items() >= {"key-mgmt": "sae", "psk": wifi.key}.items()


@pytest.mark.parametrize("ssid", HOSTILE, ids=ascii)
def test_netplan_hands_every_name_on(ssid: str, debian: Path, tmp_path: Path) -> None:
    keyfile = generated(debian, tmp_path, seed(wifi=Wifi(ssid, WIFI.key, "DE")))
    assert name_of_keyfile(keyfile["wifi"]["ssid"]) == ssid.encode()
