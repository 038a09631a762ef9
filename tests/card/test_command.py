"""``qrobot image seed`` as people meet it."""

from __future__ import annotations

import hashlib
import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
import started
from card.made import KEY, OTHER_KEY

ROOT = Path(__file__).resolve().parents[2]
WHO = ["--hostname", "robot-1", "--user", "mira"]
PASSPHRASE = "Gabelstapler 7"


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    (tmp_path / "card").mkdir()
    (tmp_path / "card/config.txt").touch()
    (tmp_path / "card/meta-data").touch()
    (tmp_path / ".ssh").mkdir()
    (tmp_path / ".ssh/id_rsa.pub").write_text("no key at all\n")
    (tmp_path / ".ssh/id_ed25519.pub").write_text(KEY + "\n")
    (tmp_path / "other.pub").write_text(OTHER_KEY + "\n")
    (tmp_path / "secret").write_text(PASSPHRASE + "\n")
    return tmp_path


def run(desk: Path, *words: str, given: str = "") -> subprocess.CompletedProcess[str]:
    home = {"HOME": str(desk)}
    return started.run("image", "seed", "card", *words, folder=desk, environment=home, given=given)


def everything(desk: Path) -> str:
    return "".join(path.read_text() for path in (desk / "card").iterdir())


def test_a_card_is_written_with_the_usual_key(desk: Path) -> None:
    done = run(desk, *WHO)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.count("written: ") == 3
    assert "ssh mira@robot-1.local" in done.stdout
    assert "make provision" in done.stdout
    assert KEY in (desk / "card/user-data").read_text()
    again = run(desk, *WHO)
    assert again.stdout.count("unchanged: ") == 3


def test_json_is_all_that_is_printed(desk: Path) -> None:
    done = run(desk, *WHO, "--json")
    report = json.loads(done.stdout)
    names = ["user-data", "network-config", "meta-data"]
    assert report["files"] == report["changed"] == [f"card/{name}" for name in names]
    assert report["instance_id"] in (desk / "card/meta-data").read_text()
    assert json.loads(run(desk, *WHO, "--json").stdout)["changed"] == []


def test_keys_from_files_and_the_input(desk: Path) -> None:
    done = run(desk, *WHO, "--key", "other.pub", "--key", "-", given=KEY)
    assert done.returncode == 0, done.stderr
    text = (desk / "card/user-data").read_text()
    assert KEY in text
    assert OTHER_KEY in text


@pytest.mark.parametrize("release", ["trixie", "bookworm"])
def test_secrets_are_derived_and_in_no_output(release: str, desk: Path) -> None:
    words = [
        *WHO, "--release", release, "--wifi-ssid", "Warehouse", "--wifi-country", "de",
        "--wifi-passphrase-file", "secret", "--password-file", "-",
    ]  # fmt: skip
    done = run(desk, *words, given="Stapler fahren\r\n")
    assert done.returncode == 0, done.stderr
    told = everything(desk) + done.stdout + done.stderr
    assert PASSPHRASE not in told
    assert "Stapler fahren" not in told
    key = hashlib.pbkdf2_hmac("sha1", PASSPHRASE.encode(), b"Warehouse", 4096, 32).hex()
    assert key in everything(desk)
    assert key not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--wifi-plain"], {"password": PASSPHRASE}),
        (["--wifi-wpa3"], {"auth": {"key-management": "sae", "password": PASSPHRASE}}),
    ],
)
def test_wpa3_gets_the_passphrase_itself(
    words: list[str], told: dict[str, object], desk: Path
) -> None:
    wifi = ["--wifi-ssid", "Warehouse", "--wifi-country", "de", "--wifi-passphrase-file", "secret"]
    done = run(desk, *WHO, *wifi, *words)
    assert done.returncode == 0, done.stderr
    assert PASSPHRASE not in done.stdout + done.stderr
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    network = yaml.safe_load((desk / "card/network-config").read_text())["network"]
    assert network["wifis"]["wlan0"]["access-points"] == {"Warehouse": told}
    (desk / "secret").write_text("0" * 64 + "\n")
    refused = run(desk, *WHO, *wifi, *words, "--force")
    assert refused.returncode == 2
    assert "--wifi-passphrase-file: is not a passphrase" in refused.stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--hostname", "a_b"], "--hostname"),
        (["--user", "root"], "--user"),
        (["--key", "missing.pub"], "missing.pub"),
        (["--key", "secret"], "secret: --key"),
        (["--key", ".ssh/id_rsa.pub"], "id_rsa.pub: --key"),
        (["--timezone", "Mars/Base"], "--timezone"),
        (["--locale", "deutsch"], "--locale"),
        (["--release", "bookworm", "--locale", "de_DE.UTF-8"], "bookworm"),
        (["--wifi-ssid", "x"], "give --wifi-country too"),
        (["--wifi-country", "DE"], "give --wifi-ssid too"),
        (["--wifi-hidden"], "give --wifi-ssid too"),
        (["--wifi-plain"], "give --wifi-ssid too"),
        (["--wifi-wpa3"], "give --wifi-ssid too"),
        (["--static-address", "10.0.0.5/0.0.0.255"], "give 10.0.0.5/24"),
        (["--static-address", "10.0.0.5/24", "--dns", "224.0.0.251"], "--dns"),
        (["--wifi-ssid", "", "--wifi-country", "DE"], "--wifi-ssid"),
        (["--wifi-ssid", "x", "--wifi-country", "DE"], "--wifi-passphrase-file"),
        (["--wifi-ssid", "x", "--wifi-country", "DE", "--wifi-passphrase-file", "card"], "card"),
        (["--password"], "--password-file"),
        (["--gateway", "10.0.0.1"], "give --static-address too"),
        (["--dns", "10.0.0.1"], "give --static-address too"),
        (["--static-address", "10.0.0.2"], "--static-address"),
        (["--key", "-", "--password-file", "-"], "only once"),
    ],
)
def test_wrong_use_gets_one_sentence(words: list[str], says: str, desk: Path) -> None:
    before = everything(desk)
    done = run(desk, *WHO, *words)
    assert done.returncode == 2, done.stderr
    (told,) = done.stderr.strip().splitlines()
    assert told.startswith("qrobot: ")
    assert says in told
    assert done.stdout == ""
    assert everything(desk) == before


def test_without_any_key_there_is_advice(desk: Path) -> None:
    for path in (desk / ".ssh").iterdir():
        path.unlink()
    done = run(desk, *WHO)
    assert done.returncode == 2
    assert "ssh-keygen -t ed25519" in done.stderr


def test_a_card_that_is_none_gets_a_warning(desk: Path) -> None:
    (desk / "card/config.txt").unlink()
    done = run(desk, *WHO, "--json")
    assert done.returncode == 0
    assert done.stderr.startswith("warning: card has no config.txt")
    assert json.loads(done.stdout)["changed"]


def test_other_settings_need_force(desk: Path) -> None:
    assert run(desk, *WHO).returncode == 0
    done = run(desk, *WHO, "--timezone", "UTC")
    assert done.returncode == 2
    assert "card/user-data" in done.stderr
    assert run(desk, *WHO, "--timezone", "UTC", "--force").returncode == 0


def test_secrets_are_asked_for_and_not_shown(desk: Path) -> None:
    words = [*WHO, "--wifi-ssid", "Warehouse", "--wifi-country", "DE", "--password"]
    code, shown = at_a_terminal(desk, words, [PASSPHRASE, "Stapler fahren", "Stapler fahren"])
    assert code == 0, shown
    assert "Passphrase of 'Warehouse'" in shown
    assert "Password of mira" in shown
    assert PASSPHRASE not in shown
    assert "Stapler" not in shown
    assert "$y$" in everything(desk) or "$6$" in everything(desk)


def at_a_terminal(desk: Path, words: list[str], answers: list[str]) -> tuple[int, str]:
    """Run the command at a terminal of its own, and answer its questions when they come."""
    mine, its = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "qrobot", "image", "seed", "card", *words],
        cwd=desk,
        env=os.environ | {"PYTHONPATH": str(ROOT), "HOME": str(desk)},
        stdin=its,
        stdout=its,
        stderr=its,
        start_new_session=True,
    )
    os.close(its)
    shown = b""
    while True:
        try:
            data = os.read(mine, 1000)
        except OSError:  # the other side is closed
            break
        shown += data
        if data.endswith(b": ") and answers:
            os.write(mine, answers.pop(0).encode() + b"\n")
    os.close(mine)
    return process.wait(), shown.decode()
