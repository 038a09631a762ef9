"""The token of the role jupyter: what is not strong as systemd reads it is made anew."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("ansible", reason="ansible-core is not installed")

PROGRAM = Path(__file__).resolve().parents[2] / "ansible/plugins/modules/qrobot_token.py"
STRONG = "f00dfeedf00dfeed0123456789abcdef"


class Module:
    """The arguments and the answer of a module that runs here."""

    def __init__(self, path: Path) -> None:
        self.params = {"path": str(path), "variable": "JUPYTER_TOKEN"}
        self.check_mode = False
        self.changed: bool | None = None

    def exit_json(self, *, changed: bool) -> None:
        self.changed = changed


def run(path: Path, monkeypatch: pytest.MonkeyPatch) -> bool | None:
    spec = importlib.util.spec_from_file_location("qrobot_token", PROGRAM)
    assert spec is not None
    assert spec.loader is not None
    program: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    module = Module(path)
    monkeypatch.setattr(program, "AnsibleModule", lambda **_: module)
    program.main()
    return module.changed


@pytest.mark.parametrize(
    "text",
    [
        None,
        "",
        "JUPYTER_TOKEN=\n",
        "JUPYTER_TOKEN=short\n",
        "JUPYTER_TOKEN=" + " " * 40 + "x\n",
        "JUPYTER_TOKEN=" + "a" * 40 + "\n",
        "JUPYTER_TOKEN=" + "abcdefg" * 6 + "\n",
        f'JUPYTER_TOKEN="" {STRONG}\n',
        f"JUPYTER_TOKEN={STRONG}\nJUPYTER_TOKEN=\n",
        f"JUPYTER_TOKEN={STRONG} {STRONG}\n",
        f"JUPYTER_TOKEN='{STRONG}\n",
        f"JUPYTER_TOKEN={STRONG}\\\n",
        f"OTHER={STRONG}\n",
        f"{STRONG}\n",
    ],
)
def test_what_is_not_a_strong_token_is_made_anew(
    text: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "token"
    if text is not None:
        path.write_text(text)
    assert run(path, monkeypatch) is True
    name, _, token = path.read_text().partition("=")
    assert name == "JUPYTER_TOKEN"
    assert len(token.strip()) == 48
    assert path.stat().st_mode & 0o777 == 0o600
    assert run(path, monkeypatch) is False, "its own token is not good enough for it"


def test_a_strong_token_stays_and_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "token"
    path.write_text(f"JUPYTER_TOKEN={STRONG}\n")
    path.chmod(0o644)
    assert run(path, monkeypatch) is True
    assert path.read_text() == f"JUPYTER_TOKEN={STRONG}\n"
    assert path.stat().st_mode & 0o777 == 0o600
    assert run(path, monkeypatch) is False
