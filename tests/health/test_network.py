"""Whether the services can be reached: loopback servers stand in for them."""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from qrobot.health.system import network
from qrobot.health.system.network import SERVICES


class Refusing(BaseHTTPRequestHandler):
    def do_HEAD(self) -> None:
        self.send_response(int(self.path.strip("/")))
        self.end_headers()

    def log_message(self, *_: object) -> None:
        pass


@pytest.mark.parametrize("code", [200, 401, 403, 404, 500, 407])
def test_a_service_that_refuses_us_is_reached(code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    with HTTPServer(("127.0.0.1", 0), Refusing) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        said = network.reach(f"http://127.0.0.1:{server.server_port}/{code}", 10)
        server.shutdown()
    assert said == ("" if code != 407 else "is behind a proxy that refuses us")


def test_silence_nonsense_and_closed_ports_are_not_reached(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        port = silent.getsockname()[1]
        assert "no answer in 0.2 s" in network.reach(f"http://127.0.0.1:{port}/", 0.2)
        # Plain text where TLS is expected.
        assert network.reach(f"https://127.0.0.1:{port}/", 0.2)
    assert "cannot be reached" in network.reach(f"http://127.0.0.1:{port}/", 5)
    assert network.reach("nonsense://", 1)
    assert network.reach("", 1)


def test_the_endpoints_are_the_sdks_own(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("dwave.cloud")
    monkeypatch.setenv("DWAVE_API_ENDPOINT", "https://user:word@leap.example.com:444/sapi/v2/?x=1")
    assert network._address("leap") == "https://leap.example.com:444/"
    monkeypatch.setenv("DWAVE_CONFIG_FILE", "")
    monkeypatch.delenv("DWAVE_API_ENDPOINT")
    assert network._address("leap").startswith("https://")


def test_the_region_of_braket_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("botocore")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "eu-west-2")
    assert "eu-west-2" in network._address("braket")


def test_endpoints_that_do_not_answer_are_warnings(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    monkeypatch.setattr(network, "_address", lambda service: f"http://127.0.0.1:{port}/")
    found = network.network_findings(1.0)
    assert [finding.name for finding in found] == [f"endpoint-{name}" for name in SERVICES]
    assert {finding.status for finding in found} <= {"warning", "unknown"}


def test_an_sdk_that_hangs_or_dies_does_not_hold_us(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network, "TELL", 0.1)
    monkeypatch.setattr(network, "_address", lambda service: time.sleep(60) or "")
    monkeypatch.setattr(network.importlib.util, "find_spec", lambda name: True)
    found = network.network_findings(0.1)
    assert {finding.status for finding in found} == {"warning"}
    assert {finding.message for finding in found} == {"gave no answer in time; check the network"}


def test_nothing_asks_the_network_unless_told() -> None:
    code = """
import socket, sys
def refuse(*a, **k): raise SystemExit("the network was asked")
socket.socket.connect = socket.getaddrinfo = refuse
from qrobot.health.system import system_findings
system_findings()
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "qrobot.health.system.network" not in done.stdout
