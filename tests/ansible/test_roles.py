"""A bare Debian machine, provisioned by the real playbooks over real SSH, and taken back again.

The tests of this file are one story in their sequence. QROBOT_ROLES=1 switches them on, for root.
The kernel is the computer's, so swap, the watchdog and the boot itself are the emulated Pi's to
prove.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import pytest
from machine import Machine, Run

LISTING = (
    "find /etc /opt /usr/local /boot /var/lib/qrobot* -printf '%p %y %s %m %u %T@\\n' 2>/dev/null"
    " | grep -v '^/etc/python3' | sort"
)
BAD = r"ansible_user=typist ansible_password=guess"
HEAL = """
set -e
current=$(readlink -f /opt/qrobot/current)
rm $current/lib/python3*/site-packages/numpy/version.py
truncate --size 0 $current/lib/python3*/site-packages/qrobot/errors.py
ln -sfn releases/of-nobody /opt/qrobot/current
rm /etc/ssh/sshd_config.d/10-qrobot.conf /usr/local/bin/qrobot /opt/qrobot/bin/uv
sed -i s/ProtectSystem=strict/ProtectSystem=no/ /etc/systemd/system/qrobot-health.service
systemctl disable --now qrobot-health.timer prometheus-node-exporter.service
nft delete table inet qrobot
systemctl disable --now nftables.service
chmod 777 /var/lib/qrobot /etc/qrobot
chown root /var/lib/qrobot-health
"""


def listing(machine: Machine) -> str:
    return machine.root(LISTING)


@pytest.fixture(scope="module")
def provisioned(provision: Callable[..., Run]) -> Run:
    """The first run on the bare machine."""
    done = provision(qrobot_compile=True)
    if done.code:
        pytest.fail(done.text[-6000:])
    return done


def test_a_check_of_a_bare_machine_foretells_and_changes_nothing(
    machine: Machine, provision: Callable[..., Run]
) -> None:
    before = listing(machine)
    done = provision("--check", "--diff")
    assert done.code == 0, done.text[-4000:]
    assert done.changed > 10
    assert listing(machine) == before


@pytest.mark.parametrize(
    ("variables", "says"),
    [
        ({"preflight_architectures": ["riscv64"]}, "qRobot's robots are riscv64"),
        ({"preflight_memory_mb": {"solver": 10**7}}, "set qrobot_profile to solver"),
        ({"qrobot_profile": "huge"}, "value of qrobot_profile must be one of"),
        ({"qrobot_jupyter": True}, "qrobot_jupyter wants qrobot_profile lab"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(
    machine: Machine, provision: Callable[..., Run], variables: dict[str, object], says: str
) -> None:
    before = listing(machine)
    done = provision(**variables)
    assert done.code != 0
    assert says in done.why()
    assert done.counts["changed"] == 0
    assert listing(machine) == before


def test_a_wrong_clock_is_refused(machine: Machine, provision: Callable[..., Run]) -> None:
    # The kernel's clock is the computer's: only the machine's Python is told another time.
    site = machine.root("readlink -f /usr/lib/python3*/sitecustomize.py").strip()
    machine.root(f"cp {site} /tmp/site.py")
    machine.root(f'echo "import time; time.time = lambda t=time.time: t() - 90000" >>{site}')
    try:
        done = provision()
    finally:
        machine.root(f"cp /tmp/site.py {site}")
    assert done.code != 0
    assert re.search(r"robot's clock is (8999\d|9000\d) s off.*timedatectl", done.why())


def test_who_has_no_key_is_not_locked_out(machine: Machine, wheel: object) -> None:
    machine.root("echo typist:guess | chpasswd")
    before = listing(machine)
    done = machine.playbook("provision.yml", inventory=BAD, qrobot_wheel=str(wheel))
    assert done.code != 0
    assert re.search(r"robot: no key logs in \(.*ermission denied.*ssh-copy-id", done.why())
    assert done.counts["ok"] > 0, "the password did log in"
    assert listing(machine) == before


def test_provisioning(machine: Machine, provisioned: Run) -> None:
    assert machine.root("qrobot --version").startswith("qrobot")
    facts = json.loads(machine.root("cat /etc/qrobot/provision.json"))
    assert facts["profile"] == "solver"
    release = machine.root("readlink /opt/qrobot/current").strip().removeprefix("releases/")
    assert f"{release} is in use and healthy" in provisioned.text
    kernels = "/opt/qrobot/current/lib/python3*/site-packages/qrobot/*/__pycache__/*.nbi"
    assert len(machine.root(f"ls {kernels}").split()) >= 3
    report = json.loads((machine.folder / "fetched/robot.json").read_text())
    assert {check["status"] for check in report["checks"]} == {"pass"}
    assert len(report["checks"]) >= 8


def test_a_second_run_changes_nothing(provisioned: Run, provision: Callable[..., Run]) -> None:
    again = provision()
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"


def test_a_check_of_the_provisioned_machine_foretells_nothing(
    machine: Machine, provisioned: Run, provision: Callable[..., Run]
) -> None:
    before = listing(machine)
    again = provision("--check", "--diff")
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"
    assert listing(machine) == before


def test_only_ssh_is_reached_from_outside(machine: Machine, provisioned: Run) -> None:
    sockets = [line.split()[4] for line in machine.root("ss -Hlntu").splitlines()]
    outside = {address for address in sockets if not re.match(r"127\.|\[::1\]", address)}
    assert outside
    assert {address.rsplit(":", 1)[1] for address in outside} == {"22"}
    assert "policy drop" in machine.root("nft list table inet qrobot")


def test_boot_files_are_set_and_the_first_ones_kept(machine: Machine, provisioned: Run) -> None:
    words = machine.root("cat /boot/firmware/cmdline.txt").split()
    assert words == [*machine.boot["cmdline.txt"].decode().split(),
                     "cgroup_enable=memory", "cgroup_memory=1"]  # fmt: skip
    config = machine.root("cat /boot/firmware/config.txt")
    assert config.startswith(machine.boot["config.txt"].decode().rstrip("\n"))
    assert "[all]\narm_64bit=1\ndtparam=watchdog=on\n" in config
    kept = machine.root("cat /boot/firmware/config.txt.before-qrobot")
    assert kept == machine.boot["config.txt"].decode()


def test_the_daily_checks_run_in_a_sandbox_and_are_shown(
    machine: Machine, provisioned: Run
) -> None:
    assert machine.root("systemctl is-active qrobot-health.timer").strip() == "active"
    # Nobody started the service: provisioning itself has, so there are metrics from the first hour.
    shown = machine.root("systemctl show --property Result --value qrobot-health.service")
    assert shown.strip() == "success"
    limits = "--property MemoryMax --property OOMScoreAdjust --property OOMPolicy"
    told = machine.root(f"systemctl show {limits} qrobot-health.service").split()
    held = dict(line.split("=") for line in told)
    assert (held["OOMScoreAdjust"], held["OOMPolicy"]) == ("500", "continue")
    assert int(held["MemoryMax"]) > 0  # bytes, not "infinity"
    modes = machine.root("stat -c '%a %U %n' /var/lib/qrobot-health/*").splitlines()
    assert {"report.json", "report.html", "qrobot.prom"} <= {m.rsplit("/", 1)[1] for m in modes}
    assert {m.rsplit(" ", 1)[0] for m in modes} == {"644 qrobot"}
    rating = machine.root("systemd-analyze security --no-pager qrobot-health.service")
    assert float(re.search(r"exposure level for \S+: ([\d.]+)", rating)[1]) < 4
    ask = "import urllib.request as r; print(r.urlopen('http://127.0.0.1:9100/metrics').read().decode())"
    metrics = machine.root(f'python3 -c "{ask}"')
    lines = machine.root("cat /var/lib/qrobot-health/qrobot.prom").splitlines()
    names = {re.split(r"[{ ]", line)[0] for line in lines if not line.startswith("#")}
    assert names
    assert all(f"\n{name}" in metrics for name in names)
    assert "node_textfile_scrape_error 0" in metrics


def test_the_sandbox_of_the_daily_checks_hides_nothing_of_the_machine(
    machine: Machine, provisioned: Run
) -> None:
    as_user = "runuser -u qrobot -- env -i HOME=/var/lib/qrobot PATH=/usr/bin:/bin LANG=C.UTF-8"
    outside = json.loads(
        machine.root(
            f"cd /var/lib/qrobot; {as_user} /usr/local/bin/qrobot health qrobot --json || true"
        )
    )
    inside = json.loads(machine.root("cat /var/lib/qrobot-health/report.json"))
    known = [
        {one["name"] for one in report["system"] if one["status"] != "unknown"}
        for report in (inside, outside)
    ]
    assert known[0] == known[1]
    assert "clock-synchronised" in known[0]
    assert "qrobot_health_clock_synchronised" in machine.root(
        "cat /var/lib/qrobot-health/qrobot.prom"
    )


@pytest.mark.parametrize("tag", ["metrics", "hardening", "credentials", "health"])
def test_a_tag_by_itself(provisioned: Run, provision: Callable[..., Run], tag: str) -> None:
    done = provision("--tags", tag)
    assert (done.code, done.changed) == (0, 0), done.text[-3000:]


def test_one_run_heals_what_was_broken(
    machine: Machine, provisioned: Run, provision: Callable[..., Run]
) -> None:
    machine.root(HEAL)
    assert machine.ssh("sudo /opt/qrobot/current/bin/qrobot --version").returncode != 0
    healed = provision()
    assert healed.code == 0, healed.text[-6000:]
    assert machine.root("qrobot --version").startswith("qrobot")
    machine.root("qrobot-release verify")
    for unit in ("qrobot-health.timer", "prometheus-node-exporter", "nftables"):
        machine.root(f"systemctl is-active {unit} && systemctl is-enabled {unit}")
    machine.root("sshd -T | grep -qx 'passwordauthentication no'")
    machine.root("nft list table inet qrobot")
    machine.root("grep -q ProtectSystem=strict /etc/systemd/system/qrobot-health.service")
    modes = machine.root("stat -c '%a %U' /var/lib/qrobot /var/lib/qrobot-health /etc/qrobot")
    assert modes.splitlines() == ["700 qrobot", "755 qrobot", "755 root"]
    again = provision()
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"


def test_a_report_that_was_removed_is_made_again(
    machine: Machine, provisioned: Run, provision: Callable[..., Run]
) -> None:
    machine.root("mkdir /tmp/kept; mv /var/lib/qrobot-health/*-*.json /tmp/kept")
    try:
        assert provision("--tags", "stacks").code == 0
    finally:
        machine.root("mv -n /tmp/kept/* /var/lib/qrobot-health; rm -r /tmp/kept")


def test_reset_wants_a_word_of_the_owner(machine: Machine, provisioned: Run) -> None:
    before = listing(machine)
    done = machine.playbook("reset.yml")
    assert done.code != 0
    assert "reset_confirm=robot" in done.why()
    assert listing(machine) == before


@pytest.fixture
def was_reset(machine: Machine, provisioned: Run) -> Run:
    machine.root("mkdir /srv/victim && echo kept >/srv/victim/kept")
    for link in ("/var/lib/qrobot/to-folder", "/var/lib/qrobot-health/to-folder"):
        machine.root(f"runuser --user=qrobot -- ln -s /srv/victim {link}")
    return machine.playbook("reset.yml", reset_confirm="robot", reset_hardening=True)


def test_reset(machine: Machine, was_reset: Run) -> None:
    assert was_reset.code == 0, was_reset.text[-4000:]
    left = listing(machine)
    ours = [line.split()[0] for line in left.splitlines() if "qrobot" in line.split()[0]]
    assert not ours
    assert not {"/etc/nftables.conf", "/etc/systemd/zram-generator.conf"} & {
        line.split()[0] for line in left.splitlines()
    }
    assert "qrobot" not in machine.root("cat /etc/passwd")
    assert machine.root("cat /srv/victim/kept").strip() == "kept"
    cmdline = machine.root("cat /boot/firmware/cmdline.txt")
    assert cmdline == machine.boot["cmdline.txt"].decode()
    assert machine.root("cat /boot/firmware/config.txt") == machine.boot["config.txt"].decode()
    assert "qrobot" not in machine.root("nft list ruleset; systemctl list-units --all")
    machine.root("sshd -T | grep -qx 'passwordauthentication yes'")


def test_provisioning_without_a_network(machine: Machine, provision: Callable[..., Run]) -> None:
    # After the reset. Now nothing but SSH reaches the machine: also not the proxy.
    gone = "prometheus-node-exporter unattended-upgrades"
    machine.root(f"apt-get purge -qq -y --autoremove {gone} >/dev/null 2>&1")
    machine.root("rm -r /var/lib/apt/lists /etc/apt/apt.conf.d/00proxy /var/cache/apt/archives")
    bare = listing(machine)
    foretold = provision("--check", "--diff", qrobot_offline=True)
    assert foretold.code == 0, foretold.text[-6000:]
    assert listing(machine) == bare
    offline = provision(qrobot_offline=True)
    assert offline.code == 0, offline.text[-6000:]
    again = provision(qrobot_offline=True)
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"
