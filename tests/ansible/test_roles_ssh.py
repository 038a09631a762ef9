"""Hardening leaves a robot reachable, also one whose sshd has another port or a socket."""

from __future__ import annotations

from machine import Machine, Run

PORT = "ansible_user=pi ansible_port=2222 ansible_ssh_private_key_file={folder}/key"
BY_CONFIG = "echo Port 2222 >/etc/ssh/sshd_config.d/50-port.conf; systemctl restart ssh.service"
BY_SOCKET = """
mkdir -p /etc/systemd/system/ssh.socket.d
printf "[Socket]\\nListenStream=\\nListenStream=2222\\n" >/etc/systemd/system/ssh.socket.d/port.conf
rm -f /etc/ssh/sshd_config.d/50-port.conf /etc/ssh/sshd_config.d/10-qrobot.conf
nft delete table inet qrobot
rm /etc/nftables.conf
systemctl daemon-reload
systemctl disable ssh.service
systemctl stop ssh.service
systemctl enable --now ssh.socket
"""


def harden(machine: Machine) -> Run:
    """Only what hardening needs, on port 2222."""
    place = PORT.format(folder=machine.folder)
    return machine.playbook(
        "provision.yml", "--tags", "base,hardening", inventory=place, qrobot_metrics=False
    )


def reached(machine: Machine) -> None:
    """A new connection gets in, by key, and keys are all that is taken."""
    said = machine.ssh("sudo sshd -T; sudo nft list table inet qrobot", check=True, port=2222)
    assert "passwordauthentication no" in said.stdout.splitlines()
    assert "tcp dport 2222 accept" in said.stdout
    assert "dport 22 accept" not in said.stdout


def test_sshd_on_another_port(machine: Machine) -> None:
    machine.root(BY_CONFIG)
    done = harden(machine)
    assert done.code == 0, done.text[-4000:]
    reached(machine)


def test_sshd_on_another_port_by_its_socket(machine: Machine) -> None:
    quoted = BY_SOCKET.replace("'", "'\\''")
    machine.ssh(f"sudo sh -c '{quoted}'", port=2222)
    assert machine.ssh("true", port=2222).returncode == 0
    done = harden(machine)
    # sshd itself does not know of the socket's port, so the packet filter closed it: taken back.
    assert done.code != 0
    assert "hardening was taken back, the robot is reachable as before" in done.why()
    left = machine.ssh("ls /etc/ssh/sshd_config.d; sudo nft list ruleset", check=True, port=2222)
    assert "qrobot" not in left.stdout
