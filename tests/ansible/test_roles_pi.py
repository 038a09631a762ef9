"""What Raspberry Pi OS has and a bare Debian has not: a journal in memory, a swap file, sudo.

One story in its sequence, on a machine of its own, of the role base only. QROBOT_ROLES=1 switches
it on, for root.
"""

from __future__ import annotations

import json
import re

import pytest
from machine import RELEASE, Machine, Run

VOLATILE = "/usr/lib/systemd/journald.conf.d/40-rpi-volatile-storage.conf"
# As the packages of Raspberry Pi OS have it. The kernel's swap is the computer's: the file is only
# made and removed, and compressed swap starts without a device.
PI = f"""
set -e
mkdir -p $(dirname {VOLATILE})
printf "[Journal]\\nStorage=volatile\\n" >{VOLATILE}
rm -rf /var/log/journal
systemctl restart systemd-journald
cat >/usr/sbin/dphys-swapfile <<"END"
#!/bin/sh
case $1 in
  setup) touch /var/swap ;;
  swapon | swapoff) echo $1 >/run/swap ;;
  uninstall) rm /var/swap ;;
esac
END
chmod 755 /usr/sbin/dphys-swapfile
cat >/usr/lib/systemd/system/dphys-swapfile.service <<"END"
[Service]
Type=oneshot
RemainAfterExit=yes
ExecStartPre=/usr/sbin/dphys-swapfile setup
ExecStart=/usr/sbin/dphys-swapfile swapon
ExecStop=/usr/sbin/dphys-swapfile swapoff
[Install]
WantedBy=multi-user.target
END
printf "[Unit]\\nConditionPathExists=/dev/zram0\\n[Swap]\\nWhat=/dev/zram0\\n" \\
  >/etc/systemd/system/dev-zram0.swap
systemctl daemon-reload
systemctl enable --now dphys-swapfile.service
"""
ASKER = """
useradd --create-home --groups sudo --shell /bin/bash asker
cp -r /home/pi/.ssh /home/asker/
chown -R asker: /home/asker/.ssh
"""


def provision(machine: Machine, *options: str, **more: object) -> Run:
    """Run the role base, and what comes before it."""
    given = {"qrobot_metrics": False, "qrobot_hardening": False, "base_zram_percent": 50} | more
    return machine.playbook("provision.yml", "--tags", "base", *options, **given)


@pytest.fixture(scope="module")
def provisioned(machine: Machine) -> Run:
    machine.root(PI)
    machine.root("logger planted-before && journalctl --sync")
    assert machine.root("ls -d /var/log/journal || true").strip() == ""
    assert machine.root("cat /run/swap; ls /var/swap").split() == ["swapon", "/var/swap"]
    done = provision(machine)
    if done.code:
        pytest.fail(done.text[-6000:])
    return done


def test_the_journal_is_on_the_card_and_small(machine: Machine, provisioned: Run) -> None:
    machine.root("logger planted-after && journalctl --sync")
    # What a watchdog leaves of it.
    kept = machine.root("journalctl --no-pager --directory /var/log/journal")
    assert "planted-before" in kept
    assert "planted-after" in kept
    settings = machine.root("systemd-analyze cat-config systemd/journald.conf").splitlines()
    said = [line for line in settings if line.startswith(("Storage=", "SystemMaxUse="))]
    assert said == ["Storage=volatile", "Storage=persistent", "SystemMaxUse=100M"]
    owner = machine.root("stat -c '%U %G %a' /var/log/journal")
    assert owner.split() == ["root", "systemd-journal", "2755"]


def test_there_is_one_kind_of_swap(machine: Machine, provisioned: Run) -> None:
    assert machine.root("cat /run/swap").strip() == "swapoff"
    machine.root("test ! -e /var/swap")
    # As the next start does.
    machine.root("systemctl start dphys-swapfile.service")
    assert machine.root("cat /run/swap").strip() == "swapoff"
    machine.root("test ! -e /var/swap")


def test_a_second_run_changes_nothing(machine: Machine, provisioned: Run) -> None:
    again = provision(machine)
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("", r"asker does not become root \(.*(assword|authentication).*--ask-become-pass"),
        ("ansible_become_password=wrong", r"asker does not become root \(.*assword"),
    ],
)
def test_sudo_that_asks_for_a_password_is_told(
    machine: Machine, provisioned: Run, more: str, says: str
) -> None:
    machine.root(f"id asker >/dev/null 2>&1 || {{ {ASKER} }}")
    place = f"ansible_user=asker ansible_ssh_private_key_file={machine.folder}/key {more}"
    done = machine.playbook("provision.yml", "--tags", "base", inventory=place)
    assert done.code != 0
    assert done.counts["changed"] == 0
    assert re.search(says, done.why()), done.text[-3000:]
    assert "NOPASSWD" in done.why()
    assert "Traceback" not in done.why()


def test_sudo_with_its_password_works(machine: Machine, provisioned: Run) -> None:
    machine.root("echo asker:right | chpasswd")
    place = f"ansible_user=asker ansible_ssh_private_key_file={machine.folder}/key"
    place += " ansible_become_password=right"
    done = machine.playbook("provision.yml", "--tags", "preflight", inventory=place)
    assert done.code == 0, done.text[-3000:]


def test_a_port_that_cannot_be_is_told_before_anything(machine: Machine, provisioned: Run) -> None:
    done = provision(machine, qrobot_hardening=True, hardening_ports=[443, "53/upd"])
    assert done.code != 0
    assert done.counts["changed"] == 0
    assert "hardening_ports[1] is '53/upd': protocol 'upd' is not known" in done.why()


def test_docker_takes_its_settings(machine: Machine, provisioned: Run) -> None:
    """Its own program reads them; whether an engine can run in this machine is not asked."""
    machine.root("apt-get install -qq -y --no-install-recommends docker.io >/dev/null 2>&1")
    provision(machine, "--tags", "docker", qrobot_docker=True)
    settings = json.loads(machine.root("cat /etc/docker/daemon.json"))
    assert settings["ip"] == "127.0.0.1"
    networks = settings.get("default-network-opts", {"bridge": {}})["bridge"]
    if RELEASE != "bookworm":
        assert networks == {"com.docker.network.bridge.host_binding_ipv4": "127.0.0.1"}
        machine.root("dockerd --validate --config-file /etc/docker/daemon.json")


def test_reset_gives_the_swap_file_back(machine: Machine, provisioned: Run) -> None:
    done = machine.playbook("reset.yml", reset_confirm="robot")
    assert done.code == 0, done.text[-4000:]
    machine.root("systemctl start dphys-swapfile.service")
    assert machine.root("cat /run/swap; ls /var/swap").split() == ["swapon", "/var/swap"]
