"""What the images are made of."""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from images.engine import ARCH, BUILT, RELEASE, docker

from qrobot import __version__

ROOT = Path(__file__).resolve().parents[2]
LOCK = {"solver": "solver", "edge": "edge", "lab": "full"}
TARGETS = tuple(LOCK)


@pytest.mark.parametrize("target", TARGETS)
def test_how_it_starts(config: Callable[[str], dict[str, Any]], target: str) -> None:
    found = config(target)
    assert re.fullmatch(r"[1-9]\d*:[1-9]\d*", found["User"])
    assert found["Entrypoint"][0].endswith("tini")
    assert found["Healthcheck"]["Test"][:4] == ["CMD", "/usr/local/bin/qrobot", "health", "--quick"]
    labels = found["Labels"]
    assert labels["org.opencontainers.image.version"] == __version__
    assert re.fullmatch(r"[0-9a-f]{40}(-dirty)?", labels["org.opencontainers.image.revision"])
    assert labels["org.opencontainers.image.licenses"] == "Apache-2.0"
    assert labels["org.opencontainers.image.title"] == f"qRobot {target}"
    ports = found.get("ExposedPorts") or {}
    assert set(ports) == ({"8888/tcp"} if target == "lab" else set())
    assert not [line for line in found["Env"] if re.search("(?i)token|secret|password", line)]


@pytest.mark.parametrize("target", TARGETS)
def test_no_tools_of_the_builder_are_in_it(run: Any, target: str) -> None:
    script = (
        "for p in gcc cc g++ ld make uv; do command -v $p; done;"
        " python3 -c 'import pip' 2>/dev/null && echo pip;"
        " find / -xdev \\( -path '*/.cache/*' -o -path '/cache/*' -o -name '*.whl'"
        " -o -path '/var/lib/apt/lists/*_Packages' -o -path '/source/*' -o -name '.git' \\)"
        " 2>/dev/null | head"
    )
    done = run(target, "sh", "-c", f"{script}; echo done", options=("--user", "0"))
    assert done.stdout.splitlines() == ["done"], done.stderr


@pytest.mark.parametrize("target", TARGETS)
def test_the_list_of_parts_is_what_is_installed(run: Any, target: str) -> None:
    """The SBOM comes from the lock; Python's own metadata must agree with it, both ways."""
    script = (
        "import importlib.metadata as m, json, pathlib;"
        "print(json.dumps({'sbom': json.loads(pathlib.Path("
        "'/usr/share/doc/qrobot/sbom.cdx.json').read_text()),"
        "'dists': sorted([d.name, d.version] for d in m.distributions())}))"
    )
    told = json.loads(run(target, "python3", "-c", script).stdout)
    sbom = told["sbom"]
    assert (sbom["bomFormat"], sbom["specVersion"]) == ("CycloneDX", "1.6")
    of_kind = {
        kind: {(re.sub(r"[-_.]+", "-", c["name"]).lower(), c["version"])
               for c in sbom["components"] if c["purl"].startswith(f"pkg:{kind}/")}
        for kind in ("pypi", "deb")
    }  # fmt: skip
    installed = {(re.sub(r"[-_.]+", "-", name).lower(), number) for name, number in told["dists"]}
    assert of_kind["pypi"] == installed
    python = "python3-13" if RELEASE == "trixie" else "python3-11"  # its dot is a dash by now
    assert {"libc6", python, "tini"} <= {name for name, _ in of_kind["deb"]}
    assert sbom["metadata"]["component"]["version"] == __version__


@pytest.mark.parametrize("target", TARGETS)
def test_everything_in_it_is_for_this_machine(run: Any, target: str) -> None:
    script = (
        "import importlib.util as u, pathlib, struct, sys\n"
        "wrong = []\n"
        "for p in pathlib.Path('/usr/local/lib').rglob('*.so*'):\n"
        "    head = p.open('rb').read(20) if p.is_file() else b''\n"
        "    if head[:4] == b'\\x7fELF': wrong.append(struct.unpack('<H', head[18:20])[0])\n"
        "print(sorted(set(wrong)), len(wrong))\n"
    )
    kinds, count = run(target, "python3", "-c", script).stdout.rsplit(maxsplit=1)
    assert kinds == {"amd64": "[62]", "arm64": "[183]"}[ARCH]
    assert int(count) > 50


@pytest.mark.parametrize("target", TARGETS)
def test_everything_is_byte_compiled(run: Any, target: str) -> None:
    """A read-only container could keep nothing that it compiles itself."""
    script = "import json, numpy, qrobot; print(*(m.__cached__ for m in (json, numpy, qrobot)))"
    files = run(target, "python3", "-c", script).stdout.split()
    assert len(files) == 3
    assert run(target, "sh", "-c", f"ls {' '.join(files)}").returncode == 0


def test_layers_are_shared(image: Callable[[str], str]) -> None:
    """What solver needs is not stored again in edge, nor edge's in lab."""
    if not {"solver", "edge"} <= {*BUILT}:
        pytest.skip("only one image was built: make test-images")
    layers = {
        target: json.loads(docker("image", "inspect", image(target)).stdout)[0]["RootFS"]["Layers"]
        for target in BUILT
    }
    stack = len(layers["solver"]) - 3  # without the list of parts, qRobot and its machine code
    assert stack >= 5  # base, etc, usr, var, the solver's packages
    assert layers["edge"][:stack] == layers["solver"][:stack]
    if "lab" in BUILT:
        assert layers["lab"][: stack + 1] == layers["edge"][: stack + 1]


def test_both_machines_are_in_one_manifest_list(image: Callable[[str], str]) -> None:
    name = image("solver")
    builder = subprocess.run(
        [ROOT / "docker/builder.sh"], capture_output=True, text=True, check=True
    )
    if builder.stdout.strip() != "buildah":
        pytest.skip("buildx makes a list in a registry only")
    subprocess.run(
        [ROOT / "docker/image.sh", "solver", "linux/arm64,linux/amd64", RELEASE],
        check=True,
        env=os.environ | {"KERNELS": ARCH},  # the other machine's would be made by an emulator
    )
    shown = subprocess.run(
        ["buildah", "manifest", "inspect", f"localhost/{name.removesuffix(f'-{ARCH}')}"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    machines = {
        entry["platform"]["architecture"] for entry in json.loads(shown.stdout)["manifests"]
    }
    assert machines == {"amd64", "arm64"}
