"""The card of a Raspberry Pi: what its first boot reads, so that a robot starts without a screen.

A `Seed` says what the robot is called, who may log in and which Wi-Fi it joins; `seed_files`
turns it into the files that Raspberry Pi OS reads on its first boot, and `write_card` puts them on
the boot partition. Secrets are hashed before they reach a file.
"""

from qrobot.card.card import RELEASES, Written, seed_files, write_card
from qrobot.card.secrets import checked_passphrase, password_hash, public_keys, wifi_key
from qrobot.card.seed import Security, Seed, StaticAddress, Wifi

__all__ = [
    "RELEASES",
    "Security",
    "Seed",
    "StaticAddress",
    "Wifi",
    "Written",
    "checked_passphrase",
    "password_hash",
    "public_keys",
    "seed_files",
    "wifi_key",
    "write_card",
]
