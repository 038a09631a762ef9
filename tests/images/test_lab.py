"""JupyterLab never starts without a token or a password."""

from __future__ import annotations

import subprocess
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from images.engine import docker
from processes import until

SCRIPT = Path(__file__).resolve().parents[2] / "docker/lab.sh"
TOKEN = "f00dfeedf00dfeedf00dfeedf00dfeed"


@pytest.fixture
def start(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the script with a jupyter-lab that tells how it was started."""
    told = tmp_path / "bin/jupyter-lab"
    told.parent.mkdir()
    told.write_text(
        '#!/bin/sh\necho "args: $*"\nenv\n'
        '[ -z "$JUPYTER_CONFIG_DIR" ] || cat "$JUPYTER_CONFIG_DIR"/*\n'
    )
    told.chmod(0o755)

    def call(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        path = f"{told.parent}:/usr/bin:/bin"
        return subprocess.run(
            ["sh", SCRIPT, *arguments], capture_output=True, text=True, check=False,
            env={"PATH": path, "TMPDIR": str(tmp_path), **environment},
        )  # fmt: skip

    return call


@pytest.mark.parametrize(
    "environment",
    [
        {},
        {"JUPYTER_TOKEN": ""},
        {"JUPYTER_TOKEN": "short"},
        {"JUPYTER_TOKEN_FILE": "/nowhere"},
        {"JUPYTER_TOKEN_FILE": "/dev/null"},
        {"JUPYTER_PASSWORD_HASH": "a password in clear"},
    ],
)
def test_it_does_not_start_without(start, environment: dict[str, str]) -> None:
    done = start(**environment)
    assert done.returncode == 2
    assert "args:" not in done.stdout
    assert "openssl rand -hex 24" in done.stderr
    assert "a password in clear" not in done.stderr


@pytest.mark.parametrize(
    "argument", ["--ServerApp.token=x", "--IdentityProvider.token=", "--NotebookApp.password=x"]
)
def test_a_token_is_no_argument(start, argument: str) -> None:
    done = start(argument, JUPYTER_TOKEN=TOKEN)
    assert done.returncode == 2
    assert "process list" in done.stderr


@pytest.mark.parametrize(
    "argument",
    ["--config=/data/x.py", "-c", "--ServerApp.identity_provider_class=x",
     "--ServerApp.allow_unauthenticated_access=True"],
)  # fmt: skip
def test_nothing_that_could_switch_the_token_off_is_an_argument(start, argument: str) -> None:
    done = start(argument, JUPYTER_TOKEN=TOKEN)
    assert done.returncode == 2
    assert "args:" not in done.stdout


@pytest.mark.parametrize(
    "words",
    [("lab",), ("jupyter", "lab"), ("jupyter-lab",), ("jupyter", "server"), ("jupyter-server",),
     ("jupyter", "notebook", "--IdentityProvider.token=")],
)  # fmt: skip
def test_no_name_of_jupyter_goes_round_the_script(run: Any, words: tuple[str, ...]) -> None:
    done = run("lab", *words)
    assert done.returncode == 2, done.stdout
    assert "openssl rand" in done.stderr


def test_other_commands_of_jupyter_pass(run: Any) -> None:
    assert "python3" in run("lab", "jupyter", "kernelspec", "list").stdout


def test_a_token_reaches_jupyter_by_the_environment_only(start, tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text(TOKEN + "\n")
    for environment in ({"JUPYTER_TOKEN": TOKEN}, {"JUPYTER_TOKEN_FILE": str(file)}):
        done = start(**environment)
        assert done.returncode == 0, done.stderr
        first, *rest = done.stdout.splitlines()
        assert TOKEN not in first
        assert f"JUPYTER_TOKEN={TOKEN}" in rest


def test_a_password_goes_into_a_private_file(start, tmp_path: Path) -> None:
    done = start(JUPYTER_PASSWORD_HASH="argon2:$argon2id$v=19$m=10240,t=10,p=8$abc$def")
    assert done.returncode == 0, done.stderr
    assert '"hashed_password": "argon2:' in done.stdout
    assert "argon2" not in done.stdout.splitlines()[0]
    assert "JUPYTER_PASSWORD_HASH=" not in done.stdout
    (config,) = [path for path in tmp_path.glob("tmp.*") if path.is_dir()]
    assert config.stat().st_mode & 0o077 == 0


def _answer(url: str, token: str | None) -> int:
    request = urllib.request.Request(url)
    if token:
        request.add_header("Authorization", f"token {token}")
    try:
        with urllib.request.urlopen(request) as reply:
            return int(reply.status)
    except urllib.error.HTTPError as error:
        return error.code


def _answers(url: str) -> bool:
    try:
        return bool(_answer(url, TOKEN))
    except OSError:
        return False


def test_the_image_lets_in_with_the_token_only(image: Callable[[str], str], tmp_path: Path) -> None:
    assert docker("run", "--rm", image("lab")).returncode == 2
    file = tmp_path / "token"
    file.write_text(TOKEN)
    file.chmod(0o644)
    tmp_path.chmod(0o755)
    started = docker("run", "-d", "--read-only", "--tmpfs", "/tmp", "--cap-drop", "ALL",
                  "--security-opt", "no-new-privileges", "-p", "127.0.0.1::8888",
                  "-v", f"{file}:/run/secrets/lab-token:ro", "--user", "10001",
                  "-e", "JUPYTER_TOKEN_FILE=/run/secrets/lab-token", image("lab"))  # fmt: skip
    name = started.stdout.strip()
    try:
        port = docker("port", name, "8888").stdout.split(":")[-1].strip()
        url = f"http://127.0.0.1:{port}/api/status"
        until(lambda: _answers(url), "the lab does not answer")
        assert _answer(url, TOKEN) == 200
        assert _answer(url, None) == 403
        assert _answer(url, "wrong" * 8) == 403
        processes = docker("top", name, "-eo", "uid,args").stdout
        assert TOKEN not in processes
        assert not [line for line in processes.splitlines()[1:] if line.split()[0] == "0"]
        assert TOKEN not in "".join(docker("logs", name).stderr)
    finally:
        docker("rm", "-f", name)
