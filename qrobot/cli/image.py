"""``qrobot image``: the card of a Raspberry Pi."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from qrobot.cli.options import FILE
from qrobot.cli.streams import say, say_json
from qrobot.errors import InputError

__all__ = ["command"]

USUAL_KEYS = ("id_ed25519.pub", "id_ecdsa.pub", "id_rsa.pub")


@click.group("image")
def command() -> None:
    """Prepare the card of a Raspberry Pi for its first boot."""


@command.command("seed")
@click.argument("dest", type=FILE)
@click.option(
    "--release",
    type=click.Choice(["trixie", "bookworm"]),
    default="trixie",
    show_default=True,
    help="Release of Raspberry Pi OS on the card.",
)
@click.option("--hostname", required=True, metavar="NAME", help="Name of the robot in the network.")
@click.option("--user", required=True, metavar="NAME", help="The account that logs in.")
@click.option(
    "--key",
    "key_files",
    type=FILE,
    multiple=True,
    help="A file with public keys, or -; may be repeated.  [default: the first of"
    f" {', '.join(USUAL_KEYS)} in ~/.ssh]",
)
@click.option("--password", "ask_password", is_flag=True, help="Ask for a password too.")
@click.option("--password-file", type=FILE, help="Read it from a file (-: standard input).")
@click.option("--wifi-ssid", metavar="NAME", help="The Wi-Fi to join; its passphrase is asked for.")
@click.option("--wifi-country", metavar="DE", help="Country that the robot works in.")
@click.option("--wifi-hidden", is_flag=True, help="The Wi-Fi does not send its name.")
@click.option("--wifi-passphrase-file", type=FILE, help="Read it from a file (-: standard input).")
@click.option(
    "--wifi-plain",
    is_flag=True,
    help="Write the passphrase itself: for access points with WPA2 and WPA3.",
)
@click.option(
    "--wifi-wpa3", is_flag=True, help="As --wifi-plain, for access points with WPA3 only."
)
@click.option("--timezone", metavar="ZONE", help="Time zone, such as Europe/Berlin.")
@click.option("--locale", metavar="NAME", help="Language and formats, such as de_DE.UTF-8.")
@click.option("--keyboard", metavar="LAYOUT", help="Keyboard layout, such as de.")
@click.option(
    "--static-address", metavar="IP/PREFIX", help="Fixed address, such as 192.168.1.20/24."
)
@click.option("--gateway", metavar="IP", help="The router, with --static-address.")
@click.option("--dns", metavar="IP", multiple=True, help="A name server; may be repeated.")
@click.option("--force", is_flag=True, help="Replace files that hold other settings.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def seed_(
    dest: str, release: str, hostname: str, user: str, key_files: tuple[str, ...],
    ask_password: bool, password_file: str | None, wifi_ssid: str | None,
    wifi_country: str | None, wifi_hidden: bool, wifi_passphrase_file: str | None,
    wifi_plain: bool, wifi_wpa3: bool, timezone: str | None, locale: str | None,
    keyboard: str | None, static_address: str | None,
    gateway: str | None, dns: tuple[str, ...], force: bool, as_json: bool,
) -> None:  # fmt: skip
    """Write name, accounts and network of a robot to a fresh card.

    DEST is the boot partition of a card that Raspberry Pi OS was written to, where it is
    mounted; or any folder. The account has no password unless one is asked for, and only keys
    log in over SSH. Neither the password nor the Wi-Fi's passphrase is written, only what is
    derived from it (but see --wifi-plain); both come from a prompt or a file, never from the
    command line.

    Exit code 0: all files are there, 2: bad input, or a file holds other settings and would be
    replaced (see --force), 3: a password cannot be hashed on this machine.

    \b
    Examples:
      qrobot image seed /media/me/bootfs --hostname robot-1 --user mira
      qrobot image seed /media/me/bootfs --hostname robot-1 --user mira \\
        --wifi-ssid Warehouse --wifi-country DE --timezone Europe/Berlin
      qrobot image seed card/ --release bookworm --hostname robot-1 --user mira --key robot.pub
    """
    from dataclasses import replace

    from qrobot.card import (
        Security,
        Seed,
        StaticAddress,
        Wifi,
        checked_passphrase,
        password_hash,
        seed_files,
        wifi_key,
        write_card,
    )

    _once([*key_files, password_file, wifi_passphrase_file])
    for option, value, other, needed in (
        ("--gateway", gateway, "--static-address", static_address),
        ("--dns", dns or None, "--static-address", static_address),
        ("--wifi-country", wifi_country, "--wifi-ssid", wifi_ssid),
        ("--wifi-hidden", wifi_hidden or None, "--wifi-ssid", wifi_ssid),
        ("--wifi-passphrase-file", wifi_passphrase_file, "--wifi-ssid", wifi_ssid),
        ("--wifi-plain", wifi_plain or None, "--wifi-ssid", wifi_ssid),
        ("--wifi-wpa3", wifi_wpa3 or None, "--wifi-ssid", wifi_ssid),
        ("--wifi-ssid", wifi_ssid, "--wifi-country", wifi_country),
    ):
        _together(option, value, other, needed)
    # Errors are reported before anything is asked: the key of the Wi-Fi comes later.
    wifi = None
    if wifi_ssid is not None and wifi_country is not None:
        security: Security = "wpa3" if wifi_wpa3 else "mixed" if wifi_plain else "wpa2"
        unknown = "0" * (64 if security == "wpa2" else 8)
        wifi = Wifi(wifi_ssid, unknown, wifi_country, wifi_hidden, security)
    seed = Seed(
        hostname,
        user,
        tuple(_keys(key_files)),
        wifi=wifi,
        timezone=timezone,
        locale=locale,
        keyboard=keyboard,
        address=None if static_address is None else StaticAddress(static_address, gateway, dns),
    )
    seed_files(seed, release)
    if wifi:
        option = "--wifi-passphrase-file"
        passphrase = _secret(wifi_passphrase_file, f"Passphrase of {wifi.ssid!a}", option)
        key = wifi_key(wifi.ssid, passphrase, field=option)
        if wifi.security != "wpa2":
            key = checked_passphrase(passphrase, field=option)
        wifi = replace(wifi, key=key)
    password = None
    if ask_password or password_file is not None:
        option = "--password-file"
        secret = _secret(password_file, f"Password of {user}", option, confirm=True)
        password = password_hash(secret, field=option)
    written = write_card(
        dest, seed_files(replace(seed, wifi=wifi, password=password), release), release, force=force
    )
    for warning in written.warnings:
        say(f"warning: {warning}", err=True)
    if as_json:
        report = {
            "files": [str(path) for path in written.files],
            "instance_id": written.instance_id,
            "changed": [str(path) for path in written.changed],
        }
        say_json(report)
        return
    for path in written.files:
        say(f"{'written' if path in written.changed else 'unchanged'}: {path}")
    say(
        "next: unmount the card, put it into the Pi, switch it on and wait a minute or two; then\n"
        f"  ssh {user}@{hostname}.local\n"
        "and, from a checkout of qRobot: make provision"
    )


def _once(paths: list[str | None]) -> None:
    if paths.count("-") > 1:
        raise InputError(
            "can be read only once", field="-", advice="give files for all options but one"
        )


def _together(option: str, value: object, other: str, needed: object) -> None:
    if value is not None and needed is None:
        raise InputError(f"means nothing without {other}", field=option, advice=f"give {other} too")


def _keys(paths: tuple[str, ...]) -> list[str]:
    """Return the keys of the files, or of the first usual file that is there."""
    from qrobot.card import public_keys

    if not paths:
        folder = Path.home() / ".ssh"
        usual = [folder / name for name in USUAL_KEYS if (folder / name).exists()]
        if not usual:
            raise InputError(
                f"no public key in {folder}",
                field="--key",
                advice="make one with: ssh-keygen -t ed25519",
            )
        paths = (str(usual[0]),)
    keys = [key for path in paths for key in public_keys(_text(path), path)]
    return list(dict.fromkeys(keys))


def _secret(path: str | None, question: str, option: str, *, confirm: bool = False) -> str:
    """Return the first line of a file, or the answer to a question, which is not shown."""
    if path is not None:
        return _text(path).split("\n")[0].removesuffix("\r")
    if not sys.stdin.isatty():
        raise InputError("there is no terminal to ask at", field=option, advice="give it")
    answer: str = click.prompt(question, hide_input=True, confirmation_prompt=confirm, err=True)
    return answer


def _text(path: str) -> str:
    from qrobot._files import read_text

    return sys.stdin.read() if path == "-" else read_text(path)
