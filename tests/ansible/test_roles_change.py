"""A provisioned machine: credentials that nobody else sees, upgrades that fail or work, and back.

One story in its sequence, on a machine of its own. QROBOT_ROLES=1 switches it on, for root.
"""

from __future__ import annotations

import configparser
import json
import os
import re
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from machine import Machine, Run
from machine_wheel import NO_MACHINE_CODE, NO_START, WRONG_PLANS, Edits, another

SECRETS = {
    "credentials_aws_access_key_id": "AKIAQROBOTPLANTED000",
    "credentials_aws_secret_access_key": "pl4nted/aws+secret/of+the+tests+0000000001",
    "credentials_ibm_token": "pl4nted-ibm-token_of-the-tests-000000000002",
    "credentials_dwave_token": "DEV-pl4nted0000000000000000000000000000000003",
}
FILES = {
    "/var/lib/qrobot/.aws/credentials",
    "/var/lib/qrobot/.qiskit/qiskit-ibm.json",
    "/var/lib/qrobot/.config/dwave/dwave.conf",
}


class Watch(threading.Thread):
    """Reads the arguments of every process on this computer, the machine's too, until told."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.ended = threading.Event()
        self.seen: set[str] = set()
        self.rounds = 0

    def run(self) -> None:
        while not self.ended.wait(0.02):
            # Not glob, which stumbles over a process that ends while it looks.
            for number in filter(str.isdigit, os.listdir("/proc")):
                try:
                    text = Path(f"/proc/{number}/cmdline").read_bytes().decode(errors="replace")
                except OSError:
                    continue
                self.seen |= {text for secret in SECRETS.values() if secret in text}
            self.rounds += 1


@pytest.fixture(scope="module")
def secrets(machine: Machine) -> Path:
    path = machine.folder / "secrets.json"
    path.touch(0o600)
    path.write_text(json.dumps(SECRETS | {"credentials_ibm_instance": "crn:v1:planted"}))
    return path


@pytest.fixture(scope="module")
def provisioned(
    machine: Machine, secrets: Path, provision: Callable[..., Run]
) -> tuple[Run, Watch]:
    """The first run, with credentials and as much output as can be had."""
    watch = Watch()
    watch.start()
    done = provision("-vvv", "--diff", "-e", f"@{secrets}")
    watch.ended.set()
    watch.join()
    if done.code:
        pytest.fail(done.text[-6000:])
    return done, watch


def release(machine: Machine) -> str:
    """The release in use."""
    return machine.root("readlink /opt/qrobot/current").strip().removeprefix("releases/")


def test_tokens_are_shown_nowhere(machine: Machine, provisioned: tuple[Run, Watch]) -> None:
    done, watch = provisioned
    for secret in SECRETS.values():
        assert secret not in done.text
        assert secret[:20] not in done.text
        files = [path for path in machine.folder.rglob("*") if path.is_file()]
        left = [path.name for path in files if secret.encode() in path.read_bytes()]
        assert left == ["secrets.json"]
    assert watch.rounds > 100
    assert watch.seen == set()


def test_tokens_lie_only_where_the_sdks_read_them(
    machine: Machine, provisioned: tuple[Run, Watch]
) -> None:
    # By stdin: sudo writes its arguments into the journal.
    machine.ssh("cat >/tmp/patterns", check=True, stdin="\n".join(SECRETS.values()) + "\n")
    places = "/etc /var /opt/qrobot/*.json /opt/qrobot/releases/*/*.json /tmp /run /root /home"
    found = machine.root(f"grep -rslF -f /tmp/patterns {places} /usr/local || true").split()
    assert set(found) == {"/tmp/patterns", *FILES}
    journal = machine.root("journalctl --no-pager -o json | grep -cF -f /tmp/patterns || true")
    assert journal.strip() == "0"
    assert int(machine.root("journalctl --no-pager | wc -l")) > 100
    for path in FILES:
        assert machine.root(f"stat -c '%a %U' {path}").strip() == "600 qrobot"
        folder = path.rsplit("/", 1)[0]
        assert machine.root(f"stat -c '%a %U' {folder}").strip() == "700 qrobot"


def test_the_sdks_files_hold_what_was_given(
    machine: Machine, provisioned: tuple[Run, Watch]
) -> None:
    def ini(path: str) -> dict[str, dict[str, str]]:
        parser = configparser.ConfigParser()
        parser.read_string(machine.root(f"cat /var/lib/qrobot/{path}"))
        return {name: dict(parser[name]) for name in parser.sections()}

    assert ini(".aws/credentials") == {"default": {
        "aws_access_key_id": SECRETS["credentials_aws_access_key_id"],
        "aws_secret_access_key": SECRETS["credentials_aws_secret_access_key"]}}  # fmt: skip
    assert ini(".aws/config") == {"default": {"region": "us-east-1"}}
    leap = ini(".config/dwave/dwave.conf")["defaults"]
    assert leap["token"] == SECRETS["credentials_dwave_token"]
    ibm = json.loads(machine.root("cat /var/lib/qrobot/.qiskit/qiskit-ibm.json"))
    account = ibm["default-ibm-quantum-platform"]
    assert account["token"] == SECRETS["credentials_ibm_token"]
    assert account["instance"] == "crn:v1:planted"
    as_user = "runuser -u qrobot -- env -i HOME=/var/lib/qrobot PATH=/usr/bin:/bin"
    said = json.loads(machine.root(f"{as_user} qrobot doctor --json || true".replace(
        "qrobot doctor", "/usr/local/bin/qrobot doctor")))  # fmt: skip
    assert {name: one["present"] for name, one in said["credentials"].items()} == {
        "aws": True, "ibm": True, "dwave": True}  # fmt: skip


def test_credentials_that_were_opened_are_closed_again(
    machine: Machine, secrets: Path, provisioned: tuple[Run, Watch]
) -> None:
    for path in FILES:
        machine.root(f"chmod 644 {path}; chmod 755 {path.rsplit('/', 1)[0]}")
    healed = machine.playbook("credentials.yml", "-e", f"@{secrets}")
    assert healed.code == 0, healed.text[-3000:]
    for path in FILES:
        assert machine.root(f"stat -c %a {path}").strip() == "600"
        assert machine.root(f"stat -c %a {path.rsplit('/', 1)[0]}").strip() == "700"
    again = machine.playbook("credentials.yml", "-e", f"@{secrets}")
    assert (again.code, again.changed) == (0, 0)


def test_half_a_key_is_refused(machine: Machine, provisioned: tuple[Run, Watch]) -> None:
    given = dict.fromkeys(SECRETS, "") | {"credentials_aws_access_key_id": "AKIAPLANTED"}
    done = machine.playbook("credentials.yml", **given)
    assert done.code != 0
    assert "AKIAPLANTED" not in done.text
    assert "one is missing: give both or none" in done.text


def test_a_link_in_the_home_leads_root_nowhere(
    machine: Machine, secrets: Path, provisioned: tuple[Run, Watch]
) -> None:
    home, victim = "/var/lib/qrobot", "/srv/victim"
    machine.root(f"mkdir {victim} && mv {home}/.aws {home}/.kept")
    machine.root(f"runuser --user=qrobot -- ln -s {victim} {home}/.aws")
    try:
        done = machine.playbook("credentials.yml", "-e", f"@{secrets}")
        assert done.code != 0
        assert f"{home}/.aws is a link, and qRobot follows none below {home}" in done.why()
        seen = machine.root(f"stat -c '%a %U' {victim}; ls -A {victim}")
        assert seen.strip() == "755 root"
    finally:
        machine.root(f"rm {home}/.aws && mv {home}/.kept {home}/.aws && rmdir {victim}")


@pytest.mark.parametrize(
    ("version", "edits", "says"),
    [
        ("0.2.0", WRONG_PLANS, "(qrobot: "),
        ("0.2.1", NO_START, "planted_fault"),
        ("0.2.2", NO_MACHINE_CODE, "not compiled: qrobot: internal error: RuntimeError: no such"),
    ],
)
def test_an_upgrade_that_fails_its_proof_leaves_the_old_release(
    machine: Machine,
    provisioned: tuple[Run, Watch],
    wheel: Path,
    tmp_path: Path,
    version: str,
    edits: Edits,
    says: str,
) -> None:
    before = release(machine)
    bad = another(wheel, tmp_path, version, edits)
    compiles = edits == NO_MACHINE_CODE
    done = machine.playbook("upgrade.yml", qrobot_wheel=str(bad), qrobot_compile=compiles)
    assert done.code != 0
    sentence = done.why()
    assert re.search(rf"robot: release {version}-solver-\w+ failed its health checks", sentence)
    assert says in sentence
    assert f"the robot runs on with {before}" in sentence
    assert "Traceback" not in sentence
    assert release(machine) == before
    assert machine.root("qrobot --version").split()[-1] == "0.1.0"
    assert version not in machine.root("ls /opt/qrobot/releases")


def test_upgrade_rollback_and_upgrade_again(
    machine: Machine, provisioned: tuple[Run, Watch], wheel: Path, tmp_path: Path
) -> None:
    first = release(machine)
    better = another(wheel, tmp_path, "0.3.0")
    done = machine.playbook("upgrade.yml", qrobot_wheel=str(better))
    assert done.code == 0, done.text[-5000:]
    second = release(machine)
    assert second.startswith("0.3.0-solver-")
    assert f"{second} is in use, before it {first}" in " ".join(done.text.split())
    assert machine.root("qrobot --version").split()[-1] == "0.3.0"

    back = machine.playbook("rollback.yml")
    assert back.code == 0, back.text[-3000:]
    assert release(machine) == first
    assert machine.root("qrobot --version").split()[-1] == "0.1.0"

    again = machine.playbook("upgrade.yml", qrobot_wheel=str(better))
    assert again.code == 0, again.text[-3000:]
    assert release(machine) == second

    newest = another(wheel, tmp_path, "0.4.0")
    done = machine.playbook("upgrade.yml", qrobot_wheel=str(newest), qrobot_keep_releases=2)
    assert done.code == 0, done.text[-3000:]
    assert sorted(machine.root("ls /opt/qrobot/releases").split()) == [second, release(machine)]
    wheels = machine.root("ls /opt/qrobot/wheels | grep ^qrobot-").split()
    assert [name.split("-")[1] for name in wheels] == ["0.3.0", "0.4.0"]
    for path in FILES:
        assert machine.root(f"stat -c '%a %U' {path}").strip() == "600 qrobot"
