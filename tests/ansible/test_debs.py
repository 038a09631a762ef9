"""The collector of Debian packages, with a repository of tiny packages on this disk."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "ansible/controller/debs.py"
TOOLS = ("apt-get", "dpkg-deb", "gpg", "gpgv", "gpgconf")
STATUS = """\
Package: base
Status: install ok installed
Priority: required
Maintainer: nobody
Architecture: arm64
Version: 1.0
Description: there already

"""

pytestmark = pytest.mark.skipif(
    not all(map(shutil.which, TOOLS)), reason=f"needs {', '.join(TOOLS)}"
)


class Signer:
    """A key of one's own that is thrown away, and what signs by it."""

    def __init__(self) -> None:
        self.home = tempfile.mkdtemp(prefix="gpg", dir="/tmp")  # short: gpg has a socket in it
        self._gpg("--quick-generate-key", "robot <robot@localhost>", "ed25519", "sign", "never")
        self.key = self._gpg("--export")

    def _gpg(self, *words: str) -> bytes:
        base = ["gpg", "--homedir", self.home, "--batch", "--quiet", "--passphrase", ""]
        return subprocess.run([*base, *words], capture_output=True, check=True).stdout

    def sign(self, path: Path, target: Path) -> None:
        self._gpg("--yes", "--output", str(target), "--clearsign", str(path))

    def close(self) -> None:
        subprocess.run(["gpgconf", "--homedir", self.home, "--kill", "all"], check=False)
        shutil.rmtree(self.home, ignore_errors=True)


@pytest.fixture(scope="module")
def signer() -> Iterator[Signer]:
    signer = Signer()
    yield signer
    signer.close()


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Robot:
    """What was fetched from a robot, the repository it names, and the program."""

    def __init__(self, folder: Path, signer: Signer) -> None:
        self.folder, self.signer = folder, signer
        self.facts, self.mirror, self.dest = (folder / name for name in ("facts", "mirror", "debs"))
        key = self.facts / "keyrings/usr/share/keyrings/robot.gpg"
        for path in (key.parent, self.facts / "sources/sources.list.d", self.mirror):
            path.mkdir(parents=True)
        key.write_bytes(signer.key)
        (self.facts / "status").write_text(STATUS)
        (self.facts / "arch").write_text("arm64\n")
        self.source = self.facts / "sources/sources.list.d/robot.sources"
        self.source.write_text(
            f"Types: deb\nURIs: file:{self.mirror}\nSuites: ./\n"
            "Signed-By: /usr/share/keyrings/robot.gpg\n"
        )
        self.package("base")
        self.package("app", depends="base, lib (>= 1:0)", recommends="extra")
        self.package("lib", version="1:2.0~rc+1")
        self.package("extra")
        self.publish()

    def package(
        self, name: str, *, version: str = "2.0", depends: str = "", recommends: str = ""
    ) -> None:
        tree = self.folder / "tree" / name
        (tree / "DEBIAN").mkdir(parents=True)
        control = [f"Package: {name}", f"Version: {version}", "Architecture: arm64"]
        control += ["Maintainer: nobody", "Description: tiny", " and made up"]
        control += [f"Depends: {depends}"] if depends else []
        control += [f"Recommends: {recommends}"] if recommends else []
        (tree / "DEBIAN/control").write_text("\n".join(control) + "\n")
        target = self.mirror / f"{name}_{version.rpartition(':')[2]}_arm64.deb"
        build = ["dpkg-deb", "--root-owner-group", "--build", str(tree), str(target)]
        subprocess.run(build, capture_output=True, check=True)

    def publish(self, signer: Signer | None = None) -> None:
        """Write the mirror's index and sign it."""
        blocks = []
        for path in sorted(self.mirror.glob("*.deb")):
            control = subprocess.run(
                ["dpkg-deb", "--field", path], capture_output=True, text=True, check=True
            ).stdout
            size = path.stat().st_size
            blocks.append(
                f"{control}Filename: ./{path.name}\nSize: {size}\nSHA256: {digest(path)}\n"
            )
        index = self.mirror / "Packages"
        index.write_text("\n".join(blocks))
        release = self.folder / "Release"
        release.write_text(
            "Suite: stable\nCodename: made-up\nDate: Sun, 01 Nov 2026 00:00:00 UTC\n"
            f"SHA256:\n {digest(index)} {index.stat().st_size} Packages\n"
        )
        (signer or self.signer).sign(release, self.mirror / "InRelease")

    def start(self, *packages: str, given: tuple[object, ...] = ()) -> tuple[int, str, str]:
        facts = given or ("--facts", self.facts)
        done = subprocess.run(
            [sys.executable, PROGRAM, "--json", *facts, "--dest", self.dest,
             "--packages", *packages],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    def run(self, *packages: str) -> dict[str, Any]:
        code, out, told = self.start(*packages)
        assert code == 0, told
        return json.loads(out)

    def refused(self, code: int, *packages: str) -> str:
        found, out, told = self.start(*packages)
        assert (found, out) == (code, ""), told
        assert "Traceback" not in told
        assert not [path for path in self.dest.glob("*") if path.is_dir()]
        return told.splitlines()[-1]


@pytest.fixture
def robot(tmp_path: Path, signer: Signer) -> Robot:
    return Robot(tmp_path, signer)


def test_exactly_what_the_robot_lacks(robot: Robot) -> None:
    """base is there already and extra is only recommended."""
    document = robot.run("app", "base")
    assert document["changed"]
    assert document["packages"] == ["app=2.0", "lib=1:2.0~rc+1"]
    folder = Path(document["path"])
    assert {file["name"] for file in document["files"]} == {
        "Packages", "app_2.0_arm64.deb", "lib_2.0~rc+1_arm64.deb"
    }  # fmt: skip
    for file in document["files"]:
        path = folder / file["name"]
        assert (file["sha256"], file["size"]) == (digest(path), path.stat().st_size)
        if path.suffix == ".deb":
            assert path.read_bytes() == (robot.mirror / path.name).read_bytes()
    assert not [*robot.dest.glob("tmp-*")]


def test_apt_installs_from_the_folder(robot: Robot, tmp_path: Path) -> None:
    """As the robot does: its own state, and this folder as its only source."""
    path = robot.run("app")["path"]
    world = tmp_path / "world"
    for name in ("lists/partial", "archives/partial", "sources", "none"):
        (world / name).mkdir(parents=True)
    shutil.copyfile(robot.facts / "status", world / "status")
    (world / "sources/offline.list").write_text(f"deb [trusted=yes] file:{path} ./\n")
    options = {
        "APT::Architecture": "arm64", "APT::Architectures": "arm64", "Dir::State": world,
        "Dir::State::status": world / "status", "Dir::Cache": world,
        "Dir::Etc::sourcelist": "/dev/null", "Dir::Etc::sourceparts": world / "sources",
        "Dir::Etc::trustedparts": world / "none", "Dir::Etc::preferencesparts": world / "none",
        "APT::Sandbox::User": "", "APT::Update::Post-Invoke": "", "APT::Install-Recommends": "0",
    }  # fmt: skip
    base = ["apt-get"]
    for key, value in options.items():
        base += ["-o", f"{key}={value}"]
    config = tmp_path / "nothing"
    config.write_text("Dir::Etc::parts /dev/null;\nDir::Etc::main /dev/null;\n")
    env = os.environ | {"LC_ALL": "C.UTF-8", "APT_CONFIG": str(config)}
    subprocess.run([*base, "update"], env=env, capture_output=True, check=True)
    told = subprocess.run(
        [*base, "--simulate", "install", "app"], env=env, capture_output=True, text=True, check=True
    ).stdout
    assert [line.split()[1] for line in told.splitlines() if line[:5] == "Inst "] == ["lib", "app"]
    # apt finds every file by the index and holds it against the sha256 there.
    fetch = [*base, "--download-only", "--yes", "install", "app"]
    subprocess.run(fetch, env=env, capture_output=True, check=True)
    broken = Path(path, "app_2.0_arm64.deb")
    broken.write_bytes(broken.read_bytes().replace(b"app", b"ppa", 1) + b"\0")
    assert subprocess.run(fetch, env=env, capture_output=True, check=False).returncode


def test_the_same_robot_asks_nobody(robot: Robot) -> None:
    first = robot.run("app")
    shutil.rmtree(robot.mirror)
    assert robot.run("app") == first | {"changed": False}
    assert robot.run("app", "app") == first | {"changed": False}


def test_a_broken_package_is_collected_again(robot: Robot) -> None:
    first = robot.run("app")
    path = Path(first["path"], "app_2.0_arm64.deb")
    path.write_bytes(path.read_bytes()[:-1])
    again = robot.run("app")
    assert again["changed"]
    assert again["files"] == first["files"]
    assert digest(path) == digest(robot.mirror / path.name)


def test_another_state_is_another_folder(robot: Robot) -> None:
    first = robot.run("app")
    lib = "Package: lib\nStatus: install ok installed\nPriority: optional\nMaintainer: nobody\n"
    lib += "Architecture: arm64\nVersion: 1:1.0\nDescription: old\n\n"
    (robot.facts / "status").write_text(STATUS + lib)
    second = robot.run("app")
    assert second["packages"] == ["app=2.0"]
    assert second["path"] != first["path"]


def test_a_robot_that_has_everything_gets_an_empty_folder(robot: Robot) -> None:
    document = robot.run("base")
    assert document["packages"] == []
    assert [file["name"] for file in document["files"]] == ["Packages"]


def test_the_older_form_of_sources_is_read_too(robot: Robot) -> None:
    robot.source.unlink()
    (robot.facts / "sources/sources.list").write_text(
        "# deb cdrom:[old] /\n"
        f"deb [arch=arm64 signed-by=/usr/share/keyrings/robot.gpg] file:{robot.mirror} ./\n"
    )
    assert robot.run("app")["packages"] == ["app=2.0", "lib=1:2.0~rc+1"]


def test_facts_in_a_tar_file(robot: Robot, tmp_path: Path) -> None:
    """As a role packs them: keys by a link, and no file for the architecture."""
    keys = robot.facts / "keyrings/usr/share/keyrings"
    (keys / "robot.gpg").rename(keys / "real.pgp")
    (keys / "robot.gpg").symlink_to("real.pgp")
    (robot.facts / "arch").unlink()
    packed = tmp_path / "robot.tgz"
    with tarfile.open(packed, "w:gz") as archive:
        for path in sorted(robot.facts.iterdir()):
            archive.add(path, path.name)
        outside = tarfile.TarInfo("../outside")
        archive.addfile(outside)
    code, out, told = robot.start("app", given=("--facts", packed, "--arch", "arm64"))
    assert code == 0, told
    assert json.loads(out)["packages"] == ["app=2.0", "lib=1:2.0~rc+1"]
    packed.write_bytes(packed.read_bytes()[:200])
    code, _, told = robot.start("app", given=("--facts", packed, "--arch", "arm64"))
    assert code == 2
    assert "is not a tar file" in told


def test_keys_for_every_source(robot: Robot) -> None:
    keys = robot.facts / "keyrings"
    robot.source.write_text(f"Types: deb\nURIs: file:{robot.mirror}\nSuites: ./\n")
    assert "not signed by a key" in robot.refused(3, "app")  # a key for those that name it
    (keys / "etc/apt/trusted.gpg.d").mkdir(parents=True)
    shutil.copyfile(keys / "usr/share/keyrings/robot.gpg", keys / "etc/apt/trusted.gpg.d/r.gpg")
    assert robot.run("app")["packages"]


def test_an_unknown_package_is_named(robot: Robot) -> None:
    told = robot.refused(2, "app", "nowhere-at-all")
    assert "no source of the robot has nowhere-at-all" in told


def test_unsigned_and_wrongly_signed_sources_are_refused(robot: Robot) -> None:
    signed = robot.mirror / "InRelease"
    shutil.copyfile(robot.folder / "Release", robot.mirror / "Release")
    signed.unlink()
    assert "not signed by a key" in robot.refused(3, "app")
    other = Signer()
    try:
        robot.publish(other)
    finally:
        other.close()
    assert "not signed by a key" in robot.refused(3, "app")
    robot.publish()
    signed.write_text(signed.read_text().replace("Suite: stable", "Suite: changed"))
    assert "not signed by a key" in robot.refused(3, "app")


def test_other_bytes_than_the_signed_index_names_are_refused(robot: Robot) -> None:
    path = robot.mirror / "lib_2.0~rc+1_arm64.deb"
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    robot.refused(3, "app")


def test_no_source_answers(robot: Robot) -> None:
    shutil.rmtree(robot.mirror)
    told = robot.refused(3, "app")
    assert "nothing was collected before" in told
    assert str(robot.mirror) not in told


def test_facts_that_are_none(robot: Robot) -> None:
    key = robot.facts / "keyrings/usr/share/keyrings/robot.gpg"
    key.rename(key.with_name("other.gpg"))
    told = robot.refused(2, "app")
    assert "the key /usr/share/keyrings/robot.gpg that robot.sources names is not there" in told
    (robot.facts / "status").write_text("nothing\n")
    assert "status is not what dpkg writes" in robot.refused(2, "app")
    (robot.facts / "arch").unlink()
    assert "arch is not readable" in robot.refused(2, "app")
    assert "is not the name of a package" in robot.refused(2, "app;rm")
