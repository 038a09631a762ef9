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

SCRIPTS = Path(__file__).resolve().parents[2] / "docker"
TOKEN = "f00dfeedf00dfeed0123456789abcdef"
ARGON = "argon2:$argon2id$v=19$m=10240,t=10,p=8$" + "c2FsdHNhbHRzYWx0c2FsdA$" + "aGFzaA" * 7 + "c"


def shell(script: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["sh", script, *arguments], capture_output=True, text=True, check=False, env=environment
    )


@pytest.fixture
def start(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the script with a jupyter-lab that tells how it was started."""
    told = tmp_path / "bin/jupyter-lab"
    told.parent.mkdir()
    told.write_text(
        '#!/bin/sh\necho "args: $*"\nenv\n'
        '[ -z "$JUPYTER_CONFIG_DIR" ] || cat "$JUPYTER_CONFIG_DIR"/* 2>/dev/null || true\n'
    )
    told.chmod(0o755)

    def call(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        path = f"{told.parent}:/usr/bin:/bin"
        everything = {"PATH": path, "TMPDIR": str(tmp_path), "HOME": str(tmp_path), **environment}
        return shell(SCRIPTS / "lab.sh", *arguments, **everything)

    return call


WEAK = {
    "none": "",
    "short": "short",
    "15 characters": TOKEN[:15],
    "16 spaces": " " * 16,
    "16 line breaks": "\n" * 16,
    "16 tabs": "\t" * 16,
    "a space inside": "f00dfeedf00d feed0123456789",
    "a line break inside": "f00dfeedf00d\nfeed0123456789",
    "a carriage return at the end": TOKEN + "\r",
    "a zero-width space": "f00dfeedf00d\u200bfeed0123456789",
    "a letter that is not ASCII": "f00dfeedf00dfeed0123456789é",
    "one character": "a" * 40,
    "two characters": "ab" * 20,
    "seven characters": "passwordpassword",
    "repeated": "12345678" * 2,
    "repeated with more": "change-me" * 3,
}


@pytest.mark.parametrize("name", WEAK)
@pytest.mark.parametrize("way", ["environment", "file"])
def test_a_weak_token_does_not_start_it(start, name: str, way: str, tmp_path: Path) -> None:
    environment = {"JUPYTER_TOKEN": WEAK[name]}
    if way == "file":
        (tmp_path / "token").write_bytes(WEAK[name].encode())
        environment = {"JUPYTER_TOKEN_FILE": str(tmp_path / "token"), "JUPYTER_TOKEN": TOKEN}
    done = start(**environment)
    assert done.returncode == 2, done.stdout
    assert "args:" not in done.stdout
    assert not WEAK[name].strip() or WEAK[name] not in done.stderr


@pytest.mark.parametrize("file", ["/nowhere", "/dev/null", "/"])
def test_a_file_without_a_token_does_not_start_it(start, file: str) -> None:
    done = start(JUPYTER_TOKEN_FILE=file)
    assert done.returncode == 2
    assert "args:" not in done.stdout


def test_the_hint_puts_nothing_on_the_process_list(start, tmp_path: Path) -> None:
    """Arguments of `docker run` stand there, those of the shell's own printf do not."""
    hint = start().stderr
    assert "--env-file" in hint
    assert "-e JUPYTER" not in hint
    assert "JUPYTER_TOKEN=" not in hint.split("docker run")[1]
    (make,) = [line for line in hint.splitlines() if "openssl rand" in line]
    done = subprocess.run(["sh", "-c", make], cwd=tmp_path, check=False, capture_output=True)
    if done.returncode:
        pytest.skip("openssl is not here")
    file = tmp_path / "lab.env"
    assert file.stat().st_mode & 0o077 == 0
    name, _, token = file.read_text().strip().partition("=")
    assert start(**{name: token}).returncode == 0
    for page in ("docker/compose.yaml", "docker/entrypoint.sh", "docker/lab.sh"):
        assert "-e JUPYTER_TOKEN=" not in (SCRIPTS.parent / page).read_text(), page


CUT_HASHES = {
    "clear text": "a password in clear",
    "the name alone": "argon2:",
    "no salt": "argon2:$argon2id$v=19$m=10240,t=10,p=8",
    "no hash": ARGON.rpartition("$")[0],
    "an empty hash": ARGON.rpartition("$")[0] + "$",
    "a short hash": ARGON.rpartition("$")[0] + "$def",
    "a short salt": "argon2:$argon2id$v=19$m=10240,t=10,p=8$abc$" + "d" * 43,
    "no memory": ARGON.replace("m=10240", "m=0"),
    "another kind": ARGON.replace("argon2id", "argon2x"),
    "without its name": ARGON.removeprefix("argon2:"),
    "more behind it": ARGON + "$x",
    "a second line": ARGON + "\nx",
    "a line before": "x\n" + ARGON,
    "JSON": ARGON + '"}, "ServerApp": {"allow_unauthenticated_access": "True',
    "sha1 alone": "sha1:",
    "sha1 without a salt": "sha1::" + "0" * 40,
    "sha1 cut": "sha1:0123456789ab:" + "0" * 39,
    "sha256 cut": "sha256:0123456789ab:" + "0" * 40,
    "another digest": "md5:0123456789ab:" + "0" * 32,
    "a blank": ARGON + " ",
}


@pytest.mark.parametrize("name", CUT_HASHES)
def test_a_hash_that_is_not_whole_does_not_start_it(start, name: str) -> None:
    done = start(JUPYTER_PASSWORD_HASH=CUT_HASHES[name], JUPYTER_TOKEN=TOKEN)
    assert done.returncode == 2, done.stdout
    assert "args:" not in done.stdout
    assert CUT_HASHES[name] not in done.stderr


@pytest.mark.parametrize(
    "hashed",
    [ARGON, ARGON.replace("argon2id", "argon2i"), "sha1:0123456789ab:" + "0a" * 20,
     "sha256:0123456789ab:" + "0a" * 32],
)  # fmt: skip
def test_whole_hashes_are_taken(start, hashed: str) -> None:
    done = start(JUPYTER_PASSWORD_HASH=hashed)
    assert done.returncode == 0, done.stderr
    assert f'{{"PasswordIdentityProvider": {{"hashed_password": "{hashed}"}}}}' in done.stdout
    assert "JUPYTER_TOKEN=\n" in done.stdout


@pytest.mark.parametrize(
    "argument",
    ["--ServerApp.token=x", "--IdentityProvider.token=", "--NotebookApp.password=x", "--TOKEN=x",
     "--PasswordIdentityProvider.hashed_password=x", "--ServerApp.allow_password_change=True"],
)  # fmt: skip
def test_a_token_is_no_argument(start, argument: str) -> None:
    done = start(argument, JUPYTER_TOKEN=TOKEN)
    assert done.returncode == 2
    assert "process list" in done.stderr


WAYS_ROUND = [
    "--config=/data/x.py", "--config", "-c", "-c=/data/x.py", "-c/data/x.py", "--conf=/data/x.py",
    "--JupyterApp.config_file=/data/x.py", "--JupyterApp.config_file_name=x",
    "--ServerApp.config_file=/data/x.py", "--LabApp.config_file=/data/x.py",
    "--JupyterApp.config_file_paths=/data", "--JupyterApp.config_dir=/data",
    "--ServerApp.identity_provider_class=x", "--ServerApp.authorizer_class=x",
    "--ServerApp.login_handler_class=x", "--ServerApp.jpserver_extensions={}",
    "--ServerApp.allow_unauthenticated_access=True", "--ServerApp.disable_check_xsrf=True",
    "--ServerApp.allow_origin=*", "--ServerApp.allow_remote_access=True",
    "--ServerApp.tornado_settings={}", "--ServerApp.cookie_secret=x",
    "--ServerApp.cookie_secret_file=/data/x", "--ServerApp.trust_xheaders=True",
    "--ServerApp.extra_template_paths=/data", "--ServerApp.sock=/data/x",
    "--Application.show_config=True", "--show-config", "--generate-config", "-y", "--allow-root",
    "--ip=0.0.0.0", "--ServerApp.root_dir=/", "--LabServerApp.x=y", "--LabApp.dev_mode=True",
    "--LabApp.default_url=lab", "--certfile=x", "--ServerApp.base_url=x", "notebook.ipynb",
    "@/data/arguments", "--", "-", "", "lab", "IdentityProvider.x=y", "--log-level", "x\ny",
]  # fmt: skip


@pytest.mark.parametrize("argument", WAYS_ROUND)
@pytest.mark.parametrize("way", [{"JUPYTER_TOKEN": TOKEN}, {"JUPYTER_PASSWORD_HASH": ARGON}])
def test_no_argument_goes_round_the_check(start, argument: str, way: dict[str, str]) -> None:
    for words in ([argument], ["--debug", argument]):
        done = start(*words, **way)
        assert done.returncode == 2, done.stdout
        assert "args:" not in done.stdout


def test_arguments_that_change_no_access_reach_jupyter(start) -> None:
    words = ["--debug", "--log-level=WARN", "--LabApp.default_url=/lab/tree/a.ipynb",
             "--ServerApp.base_url=/robot/", "--MappingKernelManager.cull_idle_timeout=3600",
             "--certfile=/run/secrets/a.pem", "--keyfile=/run/secrets/a.key"]  # fmt: skip
    done = start(*words, JUPYTER_TOKEN=TOKEN)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0].endswith(" ".join(words))


def test_no_configuration_of_the_home_or_the_environment_counts(start, tmp_path: Path) -> None:
    given = {"JUPYTER_CONFIG_DIR": "/data", "JUPYTER_CONFIG_PATH": "/data"}
    for way in ({"JUPYTER_TOKEN": TOKEN}, {"JUPYTER_PASSWORD_HASH": ARGON}):
        done = start(**way, **given)
        told = dict(line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
        assert Path(told["JUPYTER_CONFIG_DIR"]).parent == tmp_path
        assert "JUPYTER_CONFIG_PATH" not in told
        assert told["JUPYTERLAB_SETTINGS_DIR"] == f"{tmp_path}/.jupyter/lab/user-settings"


@pytest.fixture
def enter(tmp_path: Path) -> Callable[..., str]:
    """Run the entry of the image with programs that only tell their names."""
    text = (SCRIPTS / "entrypoint.sh").read_text().replace("/usr/local/bin", str(tmp_path))
    (tmp_path / "entrypoint.sh").write_text(text)
    for name in ("qrobot", "qrobot-lab", "jupyter", "jupyter-lab", "sh", "python3"):
        (tmp_path / name).write_text(f'#!/bin/sh\necho "{name}: $*"\n')
        (tmp_path / name).chmod(0o755)

    def call(*words: str) -> str:
        done = subprocess.run(
            ["/bin/sh", tmp_path / "entrypoint.sh", *words],
            env={"PATH": f"{tmp_path}:/usr/bin:/bin"}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        return done.stdout.replace(str(tmp_path), "BIN").strip()

    return call


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("lab", "qrobot-lab: "),
        ("lab --debug", "qrobot-lab: --debug"),
        ("jupyter-lab --x", "qrobot-lab: --x"),
        ("BIN/jupyter-lab --x", "qrobot-lab: --x"),
        ("BIN/jupyter lab --x", "qrobot-lab: --x"),
        ("jupyter lab --x", "qrobot-lab: --x"),
        ("jupyter server", "qrobot-lab: "),
        ("jupyter notebook", "qrobot-lab: "),
        ("jupyter --debug lab --x", "qrobot-lab: --x"),
        ("jupyter --debug lab list", "qrobot-lab: list"),
        ("jupyter lab --x list", "qrobot-lab: --x list"),
        ("jupyter lab list", "jupyter: lab list"),
        ("jupyter server password", "jupyter: server password"),
        ("jupyter kernelspec list", "jupyter: kernelspec list"),
        ("jupyter", "jupyter: "),
        ("jupyter --version", "jupyter: --version"),
        ("python3 lab", "python3: lab"),
        ("BIN/python3 x", "python3: x"),
        ("solve lab", "qrobot: solve lab"),
        ("solve jupyter lab", "qrobot: solve jupyter lab"),
        ("", "qrobot: "),
    ],
)
def test_what_the_entry_starts(enter, words: str, told: str, tmp_path: Path) -> None:
    assert enter(*words.replace("BIN", str(tmp_path)).split()) == told.strip()


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
    done = start(JUPYTER_PASSWORD_HASH=ARGON)
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
