"""Prove the playbooks on the virtual Pi: from a bare first boot to power cuts and back.

Usage: PYTHONPATH=tests python -m virtual_pi.prove [STEP ...]   (make test-virtual-pi STEPS="...")

Each step writes what it measured into build/virtual-pi/proof.json; one that fails says why and
the exit code is 1. Without names all run, in this sequence: bare, provision, again, sockets,
boot_files, secrets, heal, broken, rollback, desktop, docker, cuts, upgrade_cuts, offline, lab.
Emulated: three to four hours on two cores.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from secrets import token_hex

from virtual_pi.machine import Machine, Proof

ROOT = Path(__file__).resolve().parents[2]
EMPTY = {"changed": 0, "failed": 0, "unreachable": 0}
# A login that is not root's has no sbin on its path.
RELEASES = "sudo /usr/local/sbin/qrobot-release"

# No registry is asked: the image is a program of the machine's own with its libraries.
CONTAINER = (
    "cd / && tar -ch usr/bin/echo $(ldd /usr/bin/echo | grep -o '/[^ ]*') | "
    "sudo docker import - qrobot-proof >/dev/null && "
    "sudo docker run --rm --network none --memory 64m qrobot-proof /usr/bin/echo contained"
)


def bare(pi: Machine, proof: Proof) -> None:
    """A first boot from the card, and a check run that changes nothing."""
    pi.reset()
    proof["first_boot_seconds"] = pi.start()
    proof.hold("the card's key logs in", pi.ssh("id -un").strip() == "pi")
    before = pi.listing()
    run = pi.play("provision", "--check", "--diff")
    proof.hold("check mode on a bare machine", run.code == 0, run.tail())
    proof.hold("check mode changed nothing", pi.listing() == before)


def provision(pi: Machine, proof: Proof) -> None:
    """From bare to healthy, with every check of the profile."""
    run = pi.play("provision")
    proof.hold("provision", run.code == 0, run.tail())
    proof["provision_seconds"] = run.seconds
    proof["provision_roles"] = run.roles
    proof["provision_slowest"] = run.slowest
    report = pi.report()
    proof["checks"] = {c["name"]: c["status"] for c in report["checks"]}
    proof.hold("every check passes", {c["status"] for c in report["checks"]} == {"pass"})
    proof.hold("on the machine itself", report["machine"] == "aarch64", str(report["machine"]))
    compilers = pi.ssh("command -v gcc cc g++ rustc cmake || true").split()
    proof.hold("nothing to compile with", not compilers, str(compilers))


def again(pi: Machine, proof: Proof) -> None:
    """The second run, and the check run, change nothing."""
    run = pi.play("provision")
    proof.hold("second run", run.code == 0 and run.counts == EMPTY, f"{run.counts} {run.tail()}")
    proof["second_seconds"] = run.seconds
    run = pi.play("provision", "--check", "--diff")
    proof.hold("check run after it", run.code == 0 and run.counts == EMPTY, f"{run.counts}")


def sockets(pi: Machine, proof: Proof) -> None:
    """What listens beyond the loopback: SSH, and the base's DHCP client."""
    lines = pi.ssh("ss -H -lntu").splitlines()
    outside = [
        (words[0], words[4])
        for words in map(str.split, lines)
        if not re.match(r"(127\.|\[::1\])", words[4])
    ]
    proof["sockets"] = sorted(f"{kind} {address}" for kind, address in outside)
    rest = [
        (kind, address)
        for kind, address in outside
        if not (kind == "tcp" and address.endswith(":22"))
        and not (kind == "udp" and re.search(r":(68|546)$", address))
    ]
    proof.hold("only SSH listens, beside the DHCP client", not rest, str(rest))
    proof["failed_units"] = pi.ssh("systemctl --failed --plain --no-legend").split("\n")[:-1]
    proof.hold("no unit failed", not proof["failed_units"], str(proof["failed_units"]))


def boot_files(pi: Machine, proof: Proof) -> None:
    """Whatever part of a boot file's writing a power cut leaves, the old or the new is there."""
    files = {
        name: [before := (ROOT / "ansible/virtual-pi" / name).read_text(), before + added]
        for name, added in (("cmdline.txt", ""), ("config.txt", "dtparam=watchdog=on\n"))
    }
    files["cmdline.txt"][1] = files["cmdline.txt"][0].rstrip() + " cgroup_enable=memory\n"
    module = (ROOT / "ansible/plugins/modules/qrobot_boot.py").read_text()
    looked, lost = pi.fat_cuts(module, files)
    proof["boot_files_cuts"] = looked
    proof.hold("no cut loses a boot file", looked > 100 and not lost, "; ".join(lost[:3]))
    # The control: a module that does not sync must be found out.
    looked, lost = pi.fat_cuts(module.replace("os.sync()", "pass"), files)
    proof["boot_files_lost_without_sync"] = len(lost)
    proof.hold("without syncing some would be lost", bool(lost), f"{looked} looked at")


def secrets(pi: Machine, proof: Proof) -> None:
    """Planted tokens stay in the files made for them, while Ansible is at its most talkative."""
    mark = token_hex(6)
    tokens = {
        "credentials_aws_access_key_id": f"AKIAPLANTED{mark.upper()}",
        "credentials_aws_secret_access_key": f"planted/aws+secret/{mark}",
        "credentials_ibm_token": f"planted-ibm-{mark}",
        "credentials_dwave_token": f"DEV-planted-leap-{mark}",
    }
    vault = pi.folder / "planted.json"
    vault.touch(mode=0o600)
    vault.write_text(json.dumps(tokens))
    watch = pi.watch(list(tokens.values()))
    run = pi.play("provision", "-vvv", "--tags", "credentials", "-e", f"@{vault}")
    seen = watch()
    proof.hold("credentials are written", run.code == 0, run.tail())
    shown = [name for name, value in tokens.items() if value in run.output]
    proof.hold("-vvv shows no token", not shown, str(shown))
    proof.hold("the process list shows none", not seen, str(seen))
    journal = pi.ssh("sudo journalctl --no-pager --all")
    proof.hold("the journal has none", not any(value in journal for value in tokens.values()))
    files = pi.search(list(tokens.values()), "/etc /var /opt/qrobot /root /home /tmp /run /boot")
    wanted = {".aws/credentials", ".qiskit/qiskit-ibm.json", ".config/dwave/dwave.conf"}
    proof.hold(
        "they lie in their files only",
        {name.removeprefix("/var/lib/qrobot/") for name in files} == wanted,
        str(files),
    )
    modes = pi.ssh(f"sudo stat -c '%a %U' {' '.join(sorted(files))}").split("\n")[:-1]
    proof.hold("for their owner alone", set(modes) == {"600 qrobot"}, str(modes))
    said = json.loads(pi.ssh("sudo -u qrobot -H /usr/local/bin/qrobot doctor --json || true"))
    present = {name: found["present"] for name, found in said["credentials"].items()}
    proof.hold("qrobot finds them", all(present.values()), str(present))
    vault.unlink()


def heal(pi: Machine, proof: Proof) -> None:
    """Damage of many kinds is mended by one run, and only the damage."""
    pi.ssh(
        "sudo sh -c 'rm /etc/ssh/sshd_config.d/10-qrobot.conf; echo x >>/etc/nftables.conf; "
        "systemctl disable --now qrobot-health.timer; rm -r /var/lib/qrobot-health; "
        'f=$(find /opt/qrobot/current/ -name click -type d | head -n 1)/core.py; : >"$f"; '
        "chmod 777 /etc/qrobot'"
    )
    run = pi.play("provision")
    proof.hold("the run after the damage", run.code == 0, run.tail())
    proof["heal_seconds"] = run.seconds
    proof["heal_changed"] = run.counts["changed"]
    works = pi.ssh("qrobot solve example --deadline 3 >/dev/null && echo works")
    proof.hold("qrobot works again", "works" in works)
    run = pi.play("provision")
    proof.hold("then nothing is left to advice", run.counts == EMPTY, str(run.counts))


def broken(pi: Machine, proof: Proof) -> None:
    """An upgrade to a release whose wheel is broken leaves the old one running."""
    old = pi.ssh("readlink /opt/qrobot/current").strip()
    before = pi.ssh("ls /opt/qrobot/releases")
    run = pi.play("upgrade", "-e", f"qrobot_wheel={pi.broken_wheel()}")
    why = [line for line in run.output.splitlines() if "failed its health checks" in line]
    proof["broken_says"] = " ".join(why[0].split()) if why else ""
    proof.hold("the exit code says failed", run.code != 0)
    proof.hold("one sentence says why", bool(why), run.tail())
    proof.hold("the old release is in use", pi.ssh("readlink /opt/qrobot/current").strip() == old)
    proof.hold("and works", "cost" in pi.ssh("qrobot solve example --json --deadline 3"))
    folders = pi.ssh("ls /opt/qrobot/releases")
    proof.hold("the broken one is gone", folders == before, folders)


def rollback(pi: Machine, proof: Proof) -> None:
    """A good upgrade, and back by hand."""
    if pi.NEXT in pi.ssh("qrobot --version"):  # another step has left it there
        pi.play("rollback")
    old = pi.ssh("readlink /opt/qrobot/current").strip()
    run = pi.play("upgrade", "-e", f"qrobot_wheel={pi.next_wheel()}")
    proof.hold("upgrade", run.code == 0, run.tail())
    proof["upgrade_seconds"] = run.seconds
    new = pi.ssh("readlink /opt/qrobot/current").strip()
    proof.hold("it switched", new != old, new)
    proof.hold("to the new version", pi.NEXT in pi.ssh("qrobot --version"))
    run = pi.play("rollback")
    proof.hold("rollback", run.code == 0, run.tail())
    proof["rollback_seconds"] = run.seconds
    proof.hold("to the old one", pi.ssh("readlink /opt/qrobot/current").strip() == old)


def desktop(pi: Machine, proof: Proof) -> None:
    """VNC through a tunnel gives a frame; from outside nothing listens."""
    run = pi.play("provision", "--tags", "base,desktop", "-e", "qrobot_desktop=true")
    proof.hold("desktop", run.code == 0, run.tail())
    frame = pi.frame()
    proof["frame"] = frame
    proof.hold("a frame with a terminal on it came", frame["colours"] > 1, str(frame))
    sockets(pi, proof)


MOMENTS = (
    # (the task whose start is waited for, seconds after it)
    ("base : Install Debian's packages", 60),
    ("boot : Set what the firmware", 1),
    ("wheelhouse : Send wheels", 12),
    ("release : Install the release", 25),
    ("release : Run the health checks", 20),
    ("release : Switch to it", 3.2),
    ("hardening : Filter packets", 2),
)


def cuts(pi: Machine, proof: Proof) -> None:
    """The power is cut at many moments; it boots every time, and the next run goes on."""
    pi.reset()
    pi.start()
    held = []
    for task, delay in MOMENTS:
        reached = pi.cut_during("provision", task, delay, "-e", "qrobot_profile=solver")
        proof.hold(f"reached: {task}", reached.ok, reached.why)
        boot = pi.start()
        state = pi.ssh(f"{RELEASES} list 2>&1 || true; ls -l /opt/qrobot 2>&1 || true")
        held.append({"during": task, "after": delay, "boot_seconds": boot, "state": state[-400:]})
        proof["cuts"] = held
    run = pi.play("provision", "-e", "qrobot_profile=solver")
    proof.hold("the run after all cuts", run.code == 0, run.tail())
    run = pi.play("provision", "-e", "qrobot_profile=solver")
    proof.hold("and nothing is left to do", run.counts == EMPTY, str(run.counts))


def upgrade_cuts(pi: Machine, proof: Proof) -> None:
    """The power is cut while an upgrade is unpacked and at its switch: qRobot works on."""
    held = []
    old = pi.ssh("readlink /opt/qrobot/current").strip()
    extra = ("-e", "qrobot_profile=solver", "-e", f"qrobot_wheel={pi.next_wheel()}")
    for task, delay in (("release : Install the release", 15), ("release : Switch to it", 3.2)):
        reached = pi.cut_during("upgrade", task, delay, *extra)
        proof.hold(f"upgrade reached: {task}", reached.ok, reached.why)
        boot = pi.start()
        works = "cost" in pi.ssh("qrobot solve example --json --deadline 3")
        held.append({"during": task, "after": delay, "boot_seconds": boot})
        proof["upgrade_cuts"] = held
        proof.hold("qrobot works after the cut", works)
    run = pi.play("upgrade", *extra)
    proof.hold("the upgrade after the cuts", run.code == 0, run.tail())
    proof.hold("it switched", pi.ssh("readlink /opt/qrobot/current").strip() != old)


def offline(pi: Machine, proof: Proof) -> None:
    """A robot that reaches nothing: everything comes through SSH."""
    pi.reset()
    pi.start(network="restricted")
    alone = pi.ssh("timeout 20 getent hosts deb.debian.org || echo alone")
    proof.hold("the machine reaches nothing", "alone" in alone, alone)
    run = pi.play("provision", "-e", "qrobot_offline=true", "-e", "qrobot_profile=solver")
    proof.hold("offline provision", run.code == 0, run.tail())
    proof["offline_seconds"] = run.seconds
    run = pi.play("provision", "-e", "qrobot_offline=true", "-e", "qrobot_profile=solver")
    proof.hold("offline again", run.code == 0 and run.counts == EMPTY, f"{run.counts}")


def docker(pi: Machine, proof: Proof) -> None:
    """Docker runs a container with a bound on its memory, and listens on no network."""
    run = pi.play("provision", "--tags", "docker", "-e", "qrobot_docker=true")
    proof.hold("docker", run.code == 0, run.tail())
    proof.hold("a container runs", "contained" in pi.ssh(CONTAINER))
    sockets(pi, proof)


def lab(pi: Machine, proof: Proof) -> None:
    """The largest profile: every check passes, and Jupyter answers by its token."""
    pi.restart()  # with a network, whatever was before
    run = pi.play("provision", "-e", "qrobot_profile=lab")
    proof.hold("lab", run.code == 0, run.tail())
    proof["lab_seconds"] = run.seconds
    proof["lab_roles"] = run.roles
    proof["lab_checks"] = {c["name"]: c["status"] for c in pi.report()["checks"]}
    failed = [name for name, status in proof["lab_checks"].items() if status != "pass"]
    proof.hold("every check of the lab passes", not failed, str(failed))
    token = pi.ssh("sudo cat /etc/qrobot/jupyter.token").strip().partition("=")[2]
    answers = [pi.answer(8888, "/api/status", given) for given in ("", "wrong", token)]
    proof.hold("Jupyter answers its token only", answers == [403, 403, 200], str(answers))
    sockets(pi, proof)


STEPS = {
    step.__name__: step
    for step in (
        bare, provision, again, sockets, boot_files, secrets, heal, broken, rollback, desktop,
        docker, cuts, upgrade_cuts, offline, lab,
    )
}  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("steps", nargs="*", metavar="STEP", help=", ".join(STEPS))
    given = parser.parse_args().steps or list(STEPS)
    unknown = [name for name in given if name not in STEPS]
    if unknown:
        parser.error(f"'{unknown[0]}' is not a step; use one of {', '.join(STEPS)}")
    pi = Machine(ROOT, Path(os.environ.get("VPI_DIR", ROOT / "build/virtual-pi")))
    proof = Proof(pi.folder / "proof.json")
    for name in given:
        begin = time.monotonic()
        print(f"== {name}: {STEPS[name].__doc__}", flush=True)
        try:
            STEPS[name](pi, proof)
        except (subprocess.CalledProcessError, AssertionError) as error:
            why = f"{error} {getattr(error, 'stderr', None) or ''}"
            proof.hold(f"{name} runs to its end", False, why)
        print(f"== {name}: {time.monotonic() - begin:.0f} s", flush=True)
    print(f"{len(proof.failed)} failed; {proof.path}")
    for line in proof.failed:
        print(f"  {line}")
    return 1 if proof.failed else 0


if __name__ == "__main__":
    sys.exit(main())
