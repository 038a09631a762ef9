"""What the files of both releases say, read by parsers that are not ours."""

from __future__ import annotations

import configparser
import tomllib
from typing import Any

import pytest
from card.made import HOSTILE, KEY, OTHER_KEY, name_of_keyfile, seed
from hypothesis import given
from hypothesis import strategies as st

from qrobot.card import RELEASES, StaticAddress, Wifi, seed_files
from qrobot.card import bookworm as bookworm_files
from qrobot.card import trixie as trixie_files
from qrobot.errors import InputError

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

SECRET = "0dc0d6eb90555ed6419756b9a15ec3e3209b63df707dd508d14581f8982721af"
HASH = "$6$salt$" + "x" * 86
SSIDS = st.one_of(
    st.sampled_from(HOSTILE),
    st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1),
).filter(lambda name: len(name.encode()) <= 32)


def trixie(**changes: Any) -> dict[str, Any]:
    return {name: yaml.safe_load(text) for name, text in seed_files(seed(**changes)).items()}


def test_what_a_seed_may_consist_of_is_all_that_it_is_made_of() -> None:
    full = seed(password="$6$salt$" + "x" * 86, wifi=Wifi("a", "0" * 64, "DE"))
    assert set(seed_files(full)) == set(trixie_files.NAMES)
    assert set(seed_files(full, "bookworm")) == set(bookworm_files.NAMES)


def test_user_data_says_who_may_log_in() -> None:
    told = trixie(keys=(KEY, OTHER_KEY), timezone="UTC", locale="de_DE.UTF-8", keyboard="de")
    data = told["user-data"]
    assert seed_files(seed())["user-data"].startswith("#cloud-config\n")
    assert data["hostname"] == "robot-1"
    (user,) = data["users"]  # without "default" the image's own account is not made
    assert user["name"] == "mira"
    assert user["ssh_authorized_keys"] == [KEY, OTHER_KEY]
    assert user["lock_passwd"] is True
    assert not {"passwd", "plain_text_passwd", "hashed_passwd"} & set(user)
    assert data["ssh_pwauth"] is False
    assert data["disable_root"] is True
    assert data["package_upgrade"] is False
    assert (data["timezone"], data["locale"]) == ("UTC", "de_DE.UTF-8")
    assert data["keyboard"] == {"layout": "de"}
    assert ["systemctl", "enable", "--now", "--no-block", "ssh"] in data["runcmd"]


def test_a_password_unlocks_the_console_and_not_ssh() -> None:
    data = trixie(password=HASH)["user-data"]
    assert data["users"][0]["hashed_passwd"] == HASH
    assert data["users"][0]["lock_passwd"] is False
    assert data["ssh_pwauth"] is False


def test_what_is_not_given_is_left_as_the_image_has_it() -> None:
    data = trixie()["user-data"]
    assert not {"timezone", "locale", "keyboard"} & set(data)


def test_the_cable_is_always_there() -> None:
    network = trixie()["network-config"]["network"]
    assert network == {
        "version": 2,
        "ethernets": {"eth0": {"dhcp4": True, "optional": True}},
    }


def test_a_wifi_beside_the_cable() -> None:
    told = trixie(wifi=Wifi("Warehouse", SECRET, "de", hidden=True))
    network = told["network-config"]["network"]
    assert network["ethernets"]["eth0"]["dhcp4"] is True
    wlan = network["wifis"]["wlan0"]
    assert wlan["access-points"] == {
        "Warehouse": {
            "auth": {"key-management": "psk", "password": SECRET},
            "hidden": True,
        }
    }
    assert wlan["regulatory-domain"] == "DE"
    assert wlan["optional"] is True
    assert any("do_wifi_country DE" in command[-1] for command in told["user-data"]["runcmd"])


def test_a_static_address_is_the_wifis_where_there_is_one() -> None:
    address = StaticAddress("192.168.1.20/24", "192.168.1.1", ("9.9.9.9", "2620:fe::fe"))
    cable = trixie(address=address)["network-config"]["network"]["ethernets"]["eth0"]
    expected = {
        "dhcp4": False,
        "optional": True,
        "addresses": ["192.168.1.20/24"],
        "routes": [{"to": "0.0.0.0/0", "via": "192.168.1.1"}],
        "nameservers": {"addresses": ["9.9.9.9", "2620:fe::fe"]},
    }
    assert cable == expected
    network = trixie(address=address, wifi=Wifi("x", SECRET, "DE"))["network-config"]["network"]
    assert network["ethernets"]["eth0"] == {"dhcp4": True, "optional": True}
    assert expected.items() <= network["wifis"]["wlan0"].items()


def test_an_identity_for_each_content() -> None:
    def identity(**changes: Any) -> str:
        return str(trixie(**changes)["meta-data"]["instance-id"])

    assert identity() == identity()
    others = [
        identity(hostname="robot-2"), identity(keys=(OTHER_KEY,)), identity(timezone="UTC"),
        identity(wifi=Wifi("x", SECRET, "DE")), identity(address=StaticAddress("10.0.0.2/24")),
    ]  # fmt: skip
    assert len({identity(), *others}) == 6
    assert list(seed_files(seed()))[-1] == "meta-data", "must be written last"


def test_custom_toml_says_who_may_log_in() -> None:
    files = seed_files(seed(keys=(KEY, OTHER_KEY), timezone="UTC", keyboard="de"), "bookworm")
    assert set(files) == {"ssh", "custom.toml"}
    assert list(files)[-1] == "custom.toml", "must be written last"
    assert tomllib.loads(files["custom.toml"]) == {
        "config_version": 1,
        "system": {"hostname": "robot-1"},
        "user": {"name": "mira", "password": "!", "password_encrypted": True},
        "ssh": {
            "enabled": True,
            "password_authentication": False,
            "authorized_keys": [KEY, OTHER_KEY],
        },
        "locale": {"keymap": "de", "timezone": "UTC"},
    }


def test_bookworm_with_all_there_is() -> None:
    files = seed_files(
        seed(password=HASH, wifi=Wifi("Warehouse", SECRET, "DE", hidden=True)), "bookworm"
    )
    toml = tomllib.loads(files["custom.toml"])
    assert toml["user"]["password"] == HASH
    assert toml["wlan"] == {
        "ssid": "Warehouse",
        "password": SECRET,
        "password_encrypted": True,
        "hidden": True,
        "country": "DE",
    }
    assert files["userconf.txt"] == f"mira:{HASH}\n"
    keyfile = configparser.ConfigParser(interpolation=None)
    keyfile.read_string(files["qrobot-wifi.nmconnection"])
    assert keyfile["connection"]["type"] == "wifi"
    assert keyfile["wifi"]["ssid"] == "Warehouse"
    assert keyfile["wifi"]["hidden"] == "true"
    assert dict(keyfile["wifi-security"]) == {"key-mgmt": "wpa-psk", "psk": SECRET}
    assert len(keyfile["connection"]["uuid"]) == 36


@given(SSIDS)
def test_the_name_of_a_wifi_survives_every_file(ssid: str) -> None:
    told = seed(wifi=Wifi(ssid, SECRET, "DE"))
    network = yaml.safe_load(seed_files(told)["network-config"])
    (name,) = network["network"]["wifis"]["wlan0"]["access-points"]
    assert name_of_keyfile(name) == ssid.encode()
    files = seed_files(told, "bookworm")
    toml = tomllib.loads(files["custom.toml"])
    assert name_of_keyfile(toml["wlan"]["ssid"]) == ssid.encode()
    keyfile = configparser.ConfigParser(interpolation=None)
    keyfile.read_string(files["qrobot-wifi.nmconnection"])
    assert name_of_keyfile(keyfile["wifi"]["ssid"]) == ssid.encode()


PASSPHRASES = st.text(
    st.characters(min_codepoint=0x20, max_codepoint=0x7E), min_size=8, max_size=63
) | st.sampled_from(["a\\\\nb: #c;", "  lead in ", "'\"\"'{}[]%", "-h --plain", "= = = = ="])


@given(PASSPHRASES)
def test_a_passphrase_survives_every_file(passphrase: str) -> None:
    for security, auth in (
        ("mixed", {"password": passphrase}),
        ("wpa3", {"auth": {"key-management": "sae", "password": passphrase}}),
    ):
        wifi = Wifi("Warehouse", passphrase, "DE", security=security)
        network = yaml.safe_load(seed_files(seed(wifi=wifi))["network-config"])["network"]
        assert network["wifis"]["wlan0"]["access-points"] == {"Warehouse": auth}
        assert passphrase not in repr(wifi)
    wifi = Wifi("Warehouse", passphrase, "DE", security="mixed")
    if "\\" in passphrase or passphrase[0] in " -" or passphrase[-1] == " ":
        with pytest.raises(InputError, match="--wifi-passphrase-file") as refused:
            seed_files(seed(wifi=wifi), "bookworm")
        assert passphrase not in str(refused.value)
        return
    files = seed_files(seed(wifi=wifi), "bookworm")
    wlan = tomllib.loads(files["custom.toml"])["wlan"]
    assert (wlan["password"], wlan["password_encrypted"]) == (passphrase, False)
    assert f"\npsk={passphrase}\n" in files["qrobot-wifi.nmconnection"]


def test_bookworm_speaks_no_wpa3_alone() -> None:
    wifi = Wifi("Warehouse", "Gabelstapler 7", "DE", security="wpa3")
    with pytest.raises(InputError, match="use --wifi-plain"):
        seed_files(seed(wifi=wifi), "bookworm")


@pytest.mark.parametrize("key", [SECRET, "short", "x" * 64, "Pässwort-lang", "tab\tinside"])
@pytest.mark.parametrize("security", ["mixed", "wpa3"])
def test_wpa3_wants_the_passphrase_itself(security: Any, key: str) -> None:
    with pytest.raises(InputError, match="8 to 63") as refused:
        Wifi("Warehouse", key, "DE", security=security)
    assert key not in str(refused.value)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"locale": "de_DE.UTF-8"}, "--locale"),
        ({"address": StaticAddress("10.0.0.2/24")}, "--static-address"),
    ],
)
def test_what_bookworm_does_not_read_is_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        seed_files(seed(**changes), "bookworm")


def test_an_unknown_release_is_refused() -> None:
    with pytest.raises(InputError, match="use one of: trixie, bookworm"):
        seed_files(seed(), "forky")
    assert set(RELEASES) == {"trixie", "bookworm"}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        *(({"hostname": name}, "--hostname") for name in
          ["", "-a", "a-", "a_b", "a.local", "x" * 64, "ä", "localhost", "12", "a\n"]),
        *(({"user": name}, "--user") for name in
          ["", "root", "qrobot", "Mira", "1a", "a_b", "a.b", "x" * 33, "a:b", "a\n", "www-data"]),
        *(({"timezone": name}, "--timezone") for name in
          ["", "Europe", "Mars/Base", "../etc/passwd", "/etc/localtime", "UTC\n", "localtime",
           "Factory"]),
        *(({"locale": name}, "--locale") for name in ["", "de", "de_DE", "de_DE.utf8; x"]),
        *(({"keyboard": name}, "--keyboard") for name in ["", "d", "DE", "de us"]),
        ({"keys": ()}, "--key"),
        ({"password": "clear text"}, "not a hash"),
    ],
)  # fmt: skip
def test_values_that_are_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        seed(**changes)
    assert ";" in str(refused.value), "no advice"
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["a", "pi", "robot-1", "x" * 32])
def test_users_that_are_taken(name: str) -> None:
    assert seed(user=name).user == name


@pytest.mark.parametrize("name", ["a", "R2-D2", "x" * 63, "3d"])
def test_host_names_that_are_taken(name: str) -> None:
    assert seed(hostname=name).hostname == name


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (("", SECRET, "DE"), "--wifi-ssid"),
        (("x" * 33, SECRET, "DE"), "--wifi-ssid"),
        (("ä" * 17, SECRET, "DE"), "--wifi-ssid"),
        (("a\0b", SECRET, "DE"), "--wifi-ssid"),
        (("\udcff", SECRET, "DE"), "--wifi-ssid"),
        (("x", SECRET, "UK"), "give GB"),
        (("x", SECRET, "XX"), "--wifi-country"),
        (("x", SECRET, "DEU"), "--wifi-country"),
        (("x", "passphrase", "DE"), "not a derived key"),
    ],
)
def test_wifis_that_are_refused(values: tuple[str, str, str], says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        Wifi(*values)
    assert str(refused.value).isascii()
    assert "passphrase" not in str(refused.value)
