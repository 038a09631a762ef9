"""Files on a card: private, whole, and nothing of anybody else is lost."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from card.made import seed

from qrobot.card import seed_files, write_card
from qrobot.errors import InputError

TEXTS = seed_files(seed())
# As a fresh image has them, its comments left out.
STOCK = {
    "user-data": "#cloud-config\n# a comment\n#hostname: raspberrypi\nssh_pwauth: false\n",
    "network-config": "# a comment\nnetwork:\n  version: 2\n\n  ethernets:\n    eth0:\n"
    "      dhcp4: true\n      optional: true\n",
    "meta-data": "dsmode: local\r\ninstance_id: rpios-image\r\n",
}


@pytest.fixture
def card(tmp_path: Path) -> Path:
    (tmp_path / "config.txt").write_text("arm_64bit=1\n")
    (tmp_path / "cmdline.txt").write_text("console=tty1 root=PARTUUID=x rootwait\n")
    for name, text in STOCK.items():
        (tmp_path / name).write_bytes(text.encode())
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_fresh_card_is_written_and_then_unchanged(card: Path) -> None:
    before = contents(card)
    done = write_card(card, TEXTS, "trixie")
    assert [path.name for path in done.changed] == ["user-data", "network-config", "meta-data"]
    assert done.files == done.changed
    assert done.warnings == ()
    assert done.instance_id
    assert done.instance_id in TEXTS["meta-data"]
    after = contents(card)
    assert {name: after[name].decode() for name in TEXTS} == TEXTS
    assert set(after) == set(before), "something was left behind"
    assert all(after[name] == before[name] for name in ("config.txt", "cmdline.txt"))
    again = write_card(card, TEXTS, "trixie")
    assert again.changed == ()
    assert again.files == done.files
    assert again.instance_id == done.instance_id


@pytest.mark.parametrize("there", [False, True])
def test_only_the_owner_reads_them(there: bool, tmp_path: Path) -> None:
    if there:
        (tmp_path / "user-data").write_text("#cloud-config\n")
        (tmp_path / "user-data").chmod(0o644)
    before = os.umask(0o022)
    try:
        done = write_card(tmp_path, TEXTS, "trixie")
        assert os.umask(0o022) == 0o022, "the mask stayed changed"
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in done.files} == {0o600}


@pytest.mark.parametrize("name", ["user-data", "network-config", "meta-data"])
def test_other_settings_are_not_replaced(name: str, card: Path) -> None:
    (card / name).write_text("#cloud-config\nhostname: precious\n")
    before = contents(card)
    with pytest.raises(InputError, match=r"--force") as refused:
        write_card(card, TEXTS, "trixie")
    assert str(card / name) in str(refused.value)
    assert contents(card) == before, "a part was written"
    done = write_card(card, TEXTS, "trixie", force=True)
    assert len(done.changed) == 3
    assert (card / name).read_text() == TEXTS[name]


def test_a_changed_seed_is_not_taken_for_the_same(card: Path) -> None:
    write_card(card, TEXTS, "trixie")
    other = seed_files(seed(hostname="robot-2"))
    with pytest.raises(InputError, match="holds other settings"):
        write_card(card, other, "trixie")
    done = write_card(card, other, "trixie", force=True)
    assert {path.name for path in done.changed} == {"user-data", "meta-data"}


def test_the_script_of_an_imager_is_respected(card: Path) -> None:
    (card / "firstrun.sh").write_text("#!/bin/bash\n")
    with pytest.raises(InputError, match=r"firstrun\.sh.*--force"):
        write_card(card, TEXTS, "trixie")
    done = write_card(card, TEXTS, "trixie", force=True)
    assert "firstrun.sh" in done.warnings[0]
    assert (card / "firstrun.sh").exists()


def test_bookworm_is_written(tmp_path: Path) -> None:
    (tmp_path / "config.txt").touch()
    texts = seed_files(seed(), "bookworm")
    done = write_card(tmp_path, texts, "bookworm")
    assert done.warnings == ()
    assert done.instance_id is None
    assert (tmp_path / "ssh").read_bytes() == b""
    assert write_card(tmp_path, texts, "bookworm").changed == ()


def test_a_card_of_the_other_release_is_told(card: Path) -> None:
    (warning,) = write_card(card, seed_files(seed(), "bookworm"), "bookworm").warnings
    assert "--release trixie" in warning
    for path in card.iterdir():
        if path.name not in ("config.txt", "cmdline.txt"):
            path.unlink()
    (warning,) = write_card(card, TEXTS, "trixie").warnings
    assert "--release bookworm" in warning
    # As advised; what the wrong one left would hold secrets for ever.
    texts = seed_files(seed(), "bookworm")
    with pytest.raises(InputError, match=r"user-data: is of other settings.*--force"):
        write_card(card, texts, "bookworm")
    done = write_card(card, texts, "bookworm", force=True)
    assert done.warnings == ()
    # A network-config of DHCP by cable is what an image has itself.
    stay = {"config.txt", "cmdline.txt", "network-config"}
    assert set(contents(card)) == {*stay, *texts}


def test_an_earlier_password_and_wifi_do_not_stay_unsaid(tmp_path: Path) -> None:
    (tmp_path / "config.txt").touch()
    (tmp_path / "userconf.txt").write_text("mira:$6$abc\n")
    (tmp_path / "ssh").touch()  # holds nothing: anybody's
    texts = seed_files(seed(), "bookworm")
    with pytest.raises(InputError, match=r"userconf\.txt: is of other settings"):
        write_card(tmp_path, texts, "bookworm")
    assert set(contents(tmp_path)) == {"config.txt", "userconf.txt", "ssh"}
    write_card(tmp_path, texts, "bookworm", force=True)
    assert set(contents(tmp_path)) == {"config.txt", *texts}


def test_nothing_is_written_when_a_later_file_cannot_be(card: Path) -> None:
    (card / "network-config").unlink()
    (card / "network-config").mkdir()
    before = (card / "user-data").read_bytes()
    with pytest.raises(InputError, match="network-config: cannot be read"):
        write_card(card, TEXTS, "trixie", force=True)
    assert (card / "user-data").read_bytes() == before


def test_a_folder_that_is_no_card_is_told_and_written(tmp_path: Path) -> None:
    done = write_card(tmp_path, TEXTS, "trixie")
    assert "not the boot partition" in done.warnings[0]
    assert len(done.changed) == 3


def test_an_identity_on_the_command_line_is_told(card: Path) -> None:
    (card / "cmdline.txt").write_text("console=tty1 ds=nocloud;i=rpi-imager-17 rootwait\n")
    (warning,) = write_card(card, TEXTS, "trixie").warnings
    assert "identity" in warning


@pytest.mark.parametrize("place", ["missing", "file"])
def test_no_folder_is_refused(place: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is not a folder"):
        write_card(tmp_path / place, TEXTS, "trixie")


def test_a_folder_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "user-data").mkdir()
    with pytest.raises(InputError, match="user-data"):
        write_card(tmp_path, TEXTS, "trixie")
