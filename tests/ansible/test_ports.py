"""What the packet filter lets in: the words of an inventory, nft's own check, and real packets."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("ansible", reason="ansible-core is not installed")
jinja2 = pytest.importorskip("jinja2")
ANSIBLE = Path(__file__).resolve().parents[2] / "ansible"


def load() -> Any:
    path = ANSIBLE / "plugins/filter/qrobot_ports.py"
    spec = importlib.util.spec_from_file_location("qrobot_ports", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


filters = load()


def rendered(*ports: Any, sshd: tuple[str, ...] = ("22",)) -> str:
    """The file of the packet filter, as the role writes it."""
    environment = jinja2.Environment(trim_blocks=True, keep_trailing_newline=True)
    environment.filters |= filters.FilterModule().filters()
    template = (ANSIBLE / "roles/hardening/templates/nftables.conf.j2").read_text()
    return environment.from_string(template).render(
        hardening_ports=list(ports), hardening_ports_of_sshd=list(sshd)
    )


@pytest.mark.parametrize(
    ("entry", "rules"),
    [
        (443, ["tcp dport 443"]),
        ("443", ["tcp dport 443"]),
        (" 443/tcp ", ["tcp dport 443"]),
        ("53/udp", ["udp dport 53"]),
        ("8000-8010", ["tcp dport 8000-8010"]),
        ("8000-8000/udp", ["udp dport 8000"]),
        ({"port": 53, "protocol": "udp"}, ["udp dport 53"]),
        ({"port": "1-65535"}, ["tcp dport 1-65535"]),
        ({"port": 80, "source": "192.168.1.0/24"}, ["ip saddr 192.168.1.0/24 tcp dport 80"]),
        ({"port": 80, "source": "192.168.1.7"}, ["ip saddr 192.168.1.7 tcp dport 80"]),
        ({"port": 80, "source": "192.168.1.7/32"}, ["ip saddr 192.168.1.7 tcp dport 80"]),
        ({"port": 80, "source": "fd00::/8"}, ["ip6 saddr fd00::/8 tcp dport 80"]),
        ({"port": 80, "interface": "wlan0"}, ['iifname "wlan0" tcp dport 80']),
        (
            {"port": 9, "protocol": "udp", "source": ["10.0.0.0/8", "::1"], "interface": "eth0.5"},
            ['iifname "eth0.5" ip saddr 10.0.0.0/8 udp dport 9',
             'iifname "eth0.5" ip6 saddr ::1 udp dport 9'],
        ),
    ],
)  # fmt: skip
def test_an_entry_is_a_rule(entry: Any, rules: list[str]) -> None:
    assert filters.wrong([entry]) == ""
    lines = [line.strip() for line in rendered(entry).splitlines()]
    for rule in rules:
        assert f"{rule} accept" in lines
        led = rule.replace("dport", "ct original proto-dst").replace(
            "tcp ct", "meta l4proto tcp ct"
        )
        assert f"{led.replace('udp ct', 'meta l4proto udp ct')} accept" in lines
    assert len(lines) == len(rendered().splitlines()) + 2 * len(rules)
    # The same twice is one rule.
    assert rendered(entry, entry) == rendered(entry)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (443, "hardening_ports is 443: give a list, such as [443, 53/udp]"),
        ("443", "hardening_ports is '443': give a list, such as [443, 53/udp]"),
        ([22, "x"], "hardening_ports[1] is 'x': give 443, \"53/udp\""),
        ([0], "hardening_ports[0] is 0: ports are 1 to 65535"),
        ([65536], "ports are 1 to 65535"),
        ([-5], "give 443"),
        ([True], "hardening_ports[0] is True: give 443"),
        ([80.5], "give 443"),
        ([None], "give 443"),
        ([[80]], "give 443"),
        (["20-10"], "a range begins with its lower port"),
        (["53/upd"], "protocol 'upd' is not known; use tcp or udp"),
        (["٤٤٣"], "give 443"),
        (["80 accept; tcp dport 81"], "give 443"),
        ([{"ports": 80}], "'ports' is not known; the keys are port, protocol, source, interface"),
        ([{"protocol": "udp"}], "port is missing"),
        ([{"port": "53/udp"}], "give 443"),
        ([{"port": 80, "protocol": "sctp"}], "protocol 'sctp' is not known; use tcp or udp"),
        ([{"port": 80, "protocol": ["tcp"]}], "is not known; use tcp or udp"),
        ([{"port": 80, "source": "192.168.1.5/24"}],
         "source '192.168.1.5/24' names a host in a network: write 192.168.1.0/24"),
        ([{"port": 80, "source": "picker-1.local"}], "is not an address or a network"),
        ([{"port": 80, "source": "fe80::1%eth0"}], "is not an address or a network"),
        ([{"port": 80, "source": 3232235777}], "is not an address or a network"),
        ([{"port": 80, "source": []}], "source is empty"),
        ([{"port": 80, "interface": 'e" accept #'}], "is not a name such as eth0"),
        ([{"port": 80, "interface": "averylonginterfacename"}], "is not a name such as eth0"),
        ([{"port": 80, "interface": ""}], "is not a name such as eth0"),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_one_sentence(value: Any, says: str) -> None:
    said = filters.wrong(value)
    assert says in said
    assert "\n" not in said
    with pytest.raises(Exception, match="hardening_ports"):
        filters.ports(value)


def checked_by_nft(text: str, folder: Path) -> str:
    """What nft says of a file, in a network of its own; "" where it takes it."""
    nft = shutil.which("nft", path=f"{os.environ['PATH']}:/usr/sbin")
    if nft is None or shutil.which("unshare") is None:
        pytest.skip("no nft here (Debian: nftables)")
    alone = (
        ["unshare", "--net"]
        if os.geteuid() == 0
        else ["unshare", "--user", "--map-root-user", "--net"]
    )
    if subprocess.run([*alone, nft, "list", "ruleset"], capture_output=True).returncode:
        pytest.skip("nft cannot be tried here: no network of its own, or a kernel without nftables")
    (folder / "nftables.conf").write_text(text)
    done = subprocess.run([*alone, nft, "--check", "--file", folder / "nftables.conf"],
                          capture_output=True, text=True)  # fmt: skip
    return done.stderr if done.returncode else ""


def test_nft_takes_what_can_be_written(tmp_path: Path) -> None:
    ports = [
        443, "53/udp", "8000-8010/tcp", {"port": "1-65535", "protocol": "udp", "source": "::/0"},
        {"port": 80, "source": ["0.0.0.0/0", "fd00::/8", "10.1.2.3"], "interface": "eth0"},
        {"port": 80, "interface": "wlx00c0ca:1"},
    ]  # fmt: skip
    assert checked_by_nft(rendered(*ports, sshd=("22", "2222", "22")), tmp_path) == ""
    assert checked_by_nft(rendered(), tmp_path) == ""
    assert checked_by_nft(rendered().replace("accept", "acept"), tmp_path) != ""


port = st.one_of(
    st.integers(),
    st.booleans(),
    st.text(max_size=12),
    st.from_regex(r"\d{1,6}(-\d{1,6})?(/\w{1,4})?"),
)
entry = st.one_of(
    port,
    st.none(),
    st.fixed_dictionaries(
        {"port": port},
        optional={
            "protocol": st.sampled_from(["tcp", "udp", "icmp", "", None, 6]),
            "source": st.one_of(
                st.ip_addresses().map(str), st.text(max_size=8), st.integers(), st.none(),
                st.builds("{}/{}".format, st.ip_addresses(), st.integers(0, 140)),
            ),
            "interface": st.one_of(st.none(), st.text(max_size=17), st.just("eth0")),
        },
    ),
)  # fmt: skip


@given(st.lists(entry, max_size=4))
def test_whatever_is_written_is_a_rule_or_a_sentence(entries: list[Any]) -> None:
    said = filters.wrong(entries)
    if said:
        assert said.startswith("hardening_ports[")
        return
    plain = len(rendered().splitlines())
    text = rendered(*entries)
    assert (len(text.splitlines()) - plain) % 2 == 0  # no entry begins a line of its own
    assert text.count("{") == rendered().count("{")


# Packets

SERVE = """
import json, selectors, socket, sys
wait = selectors.DefaultSelector()
for kind, port in json.loads(sys.argv[1]):
    one = socket.socket(socket.AF_INET, socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    one.bind(("0.0.0.0", port))
    one.listen() if kind == "tcp" else None
    wait.register(one, selectors.EVENT_READ, kind)
print("ready", flush=True)
while True:
    for key, _ in wait.select():
        if key.data == "tcp":
            key.fileobj.accept()[0].close()
        else:
            key.fileobj.sendto(b"yes", key.fileobj.recvfrom(9)[1])
"""
ASK = """
import json, socket, sys
for kind, host, port in json.loads(sys.argv[1]):
    one = socket.socket(socket.AF_INET, socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM)
    one.settimeout(60)
    try:
        one.connect((host, port))
        if kind == "udp":
            one.send(b"ask")
            one.recv(9)
        print("in")
    except OSError as error:
        print("timeout" if isinstance(error, TimeoutError) else "out")
"""
ROBOT, DOCKER, NETWORK = "10.77.0.1", "172.17.0.2", "172.18.0.2"
# As Docker writes them: a published port is led to its container, and accepted.
NAT = f"""
table ip dockers {{
  chain prerouting {{ type nat hook prerouting priority dstnat;
    tcp dport 8080 dnat to {DOCKER}:80
    tcp dport 9090 dnat to {DOCKER}:80
    tcp dport 8081 dnat to {NETWORK}:80
    udp dport 5300 dnat to {DOCKER}:53
  }}
  chain forward {{ type filter hook forward priority filter - 1; policy accept;
    accept
  }}
  chain postrouting {{ type nat hook postrouting priority srcnat;
    ip saddr 172.16.0.0/12 oifname "out" masquerade
  }}
}}
"""


class Network:
    """Four networks of the kernel: somebody outside, a robot, and a container at each bridge."""

    def __init__(self) -> None:
        self.names = {name: f"qrt{os.getpid()}{name}" for name in ("o", "r", "c", "n")}
        self.servers: list[subprocess.Popen[str]] = []

    def ip(self, *words: str) -> None:
        subprocess.run(["ip", *words], check=True, capture_output=True, text=True)

    def start(self) -> None:
        names = self.names
        for name in names.values():
            self.ip("netns", "add", name)
            self.ip("-n", name, "link", "set", "lo", "up")
        bridges = (("c", "docker0", "172.17.0.1/16", f"{DOCKER}/16"),
                   ("n", "br-0123456789ab", "172.18.0.1/16", f"{NETWORK}/16"))  # fmt: skip
        self.pair("o", "r", "out", "10.77.0.2/24", "10.77.0.1/24")
        for name, bridge, here, there in bridges:
            self.ip("-n", names["r"], "link", "add", bridge, "type", "bridge")
            self.pair(name, "r", f"v{name}", there, None)
            self.ip("-n", names["r"], "link", "set", f"v{name}", "master", bridge)
            self.ip("-n", names["r"], "address", "add", here, "dev", bridge)
            self.ip("-n", names["r"], "link", "set", bridge, "up")
            self.ip("-n", names[name], "route", "add", "default", "via", here.split("/")[0])
        # Whoever is in the network can send to a container by way of the robot.
        self.ip("-n", names["o"], "route", "add", "172.16.0.0/12", "via", ROBOT)
        self.inside("r", "sysctl", "-qw", "net.ipv4.ip_forward=1")

    def pair(self, one: str, other: str, outer: str, address: str, far: str | None) -> None:
        names = self.names
        self.ip("-n", names[one], "link", "add", "eth0", "type", "veth", "peer", "name", outer,
                "netns", names[other])  # fmt: skip
        self.ip("-n", names[one], "address", "add", address, "dev", "eth0")
        self.ip("-n", names[one], "link", "set", "eth0", "up")
        self.ip("-n", names[other], "link", "set", outer, "up")
        if far:
            self.ip("-n", names[other], "address", "add", far, "dev", outer)

    def inside(self, name: str, *words: str, stdin: str = "") -> str:
        command = ["ip", "netns", "exec", self.names[name], *words]
        done = subprocess.run(command, input=stdin, capture_output=True, text=True)
        assert done.returncode == 0, (words, done.stderr)
        return done.stdout

    def serve(self, name: str, *ports: tuple[str, int]) -> None:
        command = [
            "ip",
            "netns",
            "exec",
            self.names[name],
            sys.executable,
            "-c",
            SERVE,
            json.dumps(ports),
        ]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.servers.append(server)
        assert server.stdout is not None
        assert server.stdout.readline() == "ready\n"

    def ask(self, name: str, *targets: tuple[str, str, int]) -> list[str]:
        return self.inside(name, sys.executable, "-c", ASK, json.dumps(targets)).split()

    def stop(self) -> None:
        for server in self.servers:
            server.kill()
            server.communicate()
        for name in self.names.values():
            subprocess.run(["ip", "netns", "delete", name], capture_output=True, check=False)


@pytest.fixture
def network() -> Iterator[Network]:
    if os.geteuid() or shutil.which("ip") is None or shutil.which("nft") is None:
        pytest.skip("networks of the kernel want root, iproute2 and nftables")
    made = Network()
    try:
        try:
            made.start()
        except (AssertionError, subprocess.CalledProcessError) as error:  # of ip and sysctl
            pytest.skip(f"no networks of the kernel can be made here: {error}")
        yield made
    finally:
        made.stop()


def test_packets_go_where_they_may(network: Network) -> None:
    network.inside("r", "nft", "--file", "-", stdin=NAT)
    network.serve(
        "r", ("tcp", 22), ("tcp", 443), ("tcp", 8443), ("tcp", 7000), ("udp", 53), ("udp", 54)
    )
    network.serve("c", ("tcp", 80), ("udp", 53))
    network.serve("n", ("tcp", 80))
    network.serve("o", ("tcp", 80))
    asked = [
        ("tcp", ROBOT, 22), ("tcp", ROBOT, 443), ("tcp", ROBOT, 8443), ("tcp", ROBOT, 7000),
        ("udp", ROBOT, 53), ("udp", ROBOT, 54), ("tcp", ROBOT, 8080), ("tcp", ROBOT, 8081),
        ("tcp", ROBOT, 9090), ("udp", ROBOT, 5300), ("tcp", DOCKER, 80), ("tcp", NETWORK, 80),
    ]  # fmt: skip
    # The network itself works: everything is open without a filter.
    assert network.ask("o", *asked) == ["in"] * len(asked)
    rules = rendered(
        443, "53/udp", 9090, "5300/udp",
        {"port": 7000, "source": "10.77.0.0/24", "interface": "out"},
        {"port": 8443, "source": "10.78.0.0/24"}, {"port": 8080, "interface": "eth9"},
    )  # fmt: skip
    # Refused at once, in place of no answer: nobody waits for a clock.
    rules = rules.replace(" drop\n", " reject\n").replace(" drop comment", " reject comment")
    rules = rules.replace("  }\n  # A port", "    reject\n  }\n  # A port")
    assert rules.count("reject") == 5
    network.inside("r", "nft", "--file", "-", stdin=rules)
    assert network.ask("o", *asked) == [
        "in", "in", "out", "in", "in", "out", "out", "out", "in", "in", "out", "out",
    ]  # fmt: skip
    # Containers reach the outside, and each other by the robot as before.
    outside = [("tcp", "10.77.0.2", 80)]
    assert network.ask("c", *outside, ("tcp", NETWORK, 80)) == ["in", "in"]
    assert network.ask("n", *outside) == ["in"]
