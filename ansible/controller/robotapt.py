"""The controller's apt with a robot's eyes: its state, its sources, its keys, its architecture.

Nothing of the controller's own package state is read or written; root is not needed. How this
machine reaches the network (proxies, logins of mirrors) is the controller's and stays.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from common import sha256

from qrobot.errors import BackendError, InputError, RemoteError

UNSIGNED = re.compile(
    r"NO_PUBKEY|BADSIG|EXPKEYSIG|REVKEYSIG|is not signed|no longer signed|GPG error"
    r"|signatures? (?:were|was) invalid|Clearsigned file isn't valid|NOSPLIT|Missing key"
)
UNKNOWN = re.compile(r"Unable to locate package (\S+)|Package '?([^\s']+)'? has no installation")
URI = re.compile(r"^'([^']*)' (\S+) (\d+) SHA256:([0-9a-f]{64})$", re.MULTILINE)
# What the controller itself does after an update, such as emptying its cache, is not for here.
CONFIG = """\
#clear APT::Architectures;
#clear APT::Update;
#clear APT::NeverAutoRemove;
#clear Dpkg::Pre-Install-Pkgs;
#clear Dpkg::Pre-Invoke;
#clear Dpkg::Post-Invoke;
APT::Architecture "{arch}";
APT::Architectures {{ "{arch}"; }};
APT::Get::AllowUnauthenticated "false";
APT::Install-Recommends "false";
APT::Install-Suggests "false";
APT::Sandbox::User "";
APT::Update::Error-Mode "any";
Acquire::AllowInsecureRepositories "false";
Acquire::AllowDowngradeToInsecureRepositories "false";
Acquire::AllowWeakRepositories "false";
Acquire::ForceHash "sha256";
Acquire::Languages "none";
Acquire::Retries "2";
Dir::Cache "{root}/cache";
Dir::State "{root}/state";
Dir::State::status "{root}/state/status";
Dir::Etc::sourcelist "/dev/null";
Dir::Etc::sourceparts "{root}/sources";
Dir::Etc::trusted "/dev/null";
Dir::Etc::trustedparts "{root}/trusted";
Dir::Etc::preferences "/dev/null";
Dir::Etc::preferencesparts "{root}/preferences";
"""


@dataclass(frozen=True)
class Wanted:
    """A package that the robot lacks, as the signed index describes it."""

    uri: str = field(repr=False)  # never shown: it may name a mirror of one's own
    cached: str
    size: int
    sha256: str

    @property
    def name(self) -> str:
        """The file's name without the epoch, which apt writes in a way that needs quoting."""
        return re.sub(r"_\d+%3a", "_", self.cached)


class Apt:
    """apt for one robot, in a folder that is its whole world.

    Parameters
    ----------
    facts
        What was fetched: ``status``, ``sources/`` (sources.list, sources.list.d) and
        ``keyrings/`` (/usr/share/keyrings, /etc/apt/keyrings, /etc/apt/trusted.gpg.d, each by its
        path or by its last part; files that lie flat are found by name).
    arch
        Debian's name of the robot's machine, such as ``arm64``.
    root
        An empty folder to be made, by its absolute path.
    """

    def __init__(self, facts: Path, arch: str, root: Path) -> None:
        self.root = root
        for name in ("cache/archives/partial", "state/lists/partial", "sources", "trusted",
                     "preferences", "keys"):  # fmt: skip
            (root / name).mkdir(parents=True)
        shutil.copyfile(facts / "status", root / "state" / "status")
        self._keys(facts / "keyrings")
        self._sources(facts / "sources")
        self.config = root / "apt.conf"
        self.config.write_text(CONFIG.format(root=root, arch=arch))

    def _keys(self, folder: Path) -> None:
        """Take the robot's keys over: those for every source, and those that a source names."""
        self.keys: dict[str, Path] = {}
        for number, path in enumerate(sorted(folder.rglob("*"))):
            if not path.is_file() or path.suffix not in {".gpg", ".asc", ".pgp"}:
                continue
            ending = ".asc" if path.suffix == ".asc" else ".gpg"  # older apts know no .pgp
            trusted = "trusted.gpg.d" in path.parts or path.name == "trusted.gpg"
            place = "trusted" if trusted else "keys"
            copy = self.root / place / f"{number}-{path.stem}{ending}"
            shutil.copyfile(path, copy)
            # by its whole path on the robot, and by its name; the first of a name is the one
            self.keys[f"/{path.relative_to(folder)}"] = copy
            self.keys.setdefault(path.name, copy)

    def _sources(self, folder: Path) -> None:
        texts = [path for path in sorted(folder.rglob("*")) if path.suffix in {".list", ".sources"}]
        if not texts:
            advice = "fetch the robot's facts again"
            raise InputError("they name no source", field="--facts", advice=advice)
        for number, path in enumerate(texts):
            rewritten = self._signed_by(path.read_text(), path.name)
            (self.root / "sources" / f"{number}{path.suffix}").write_text(rewritten)

    def _signed_by(self, text: str, name: str) -> str:
        """Let a source's ``Signed-By`` point at the keys that were fetched."""

        def key(found: re.Match[str]) -> str:
            copy = self.keys.get(found[0]) or self.keys.get(Path(found[0]).name)
            if copy is None:
                raise InputError(
                    f"the key {found[0]} that {name} names is not there",
                    field="--facts", advice="fetch the robot's keyrings again",
                )  # fmt: skip
            return str(copy)

        def value(found: re.Match[str]) -> str:
            return found[1] + re.sub(r"/[^\s,\]\"]+", key, found[2])

        # The one-line form holds it in brackets; in the other one it is a field, whose value may
        # be the key itself on lines of its own: those have no path in their first line.
        return re.sub(
            r"^([ \t]*deb(?:-src)?[ \t]+\[[^\]\n]*?signed-by=|Signed-By:[ \t]*)([^\s\]]*[^\]\n]*)",
            value, text, flags=re.MULTILINE | re.IGNORECASE,
        )  # fmt: skip

    def update(self) -> None:
        """Read the lists of the robot's sources, signatures checked by the robot's keys."""
        done = self._get("update")
        if UNSIGNED.search(done.stderr):
            raise RemoteError(
                "a source of the robot is not signed by a key that the robot trusts: nothing was "
                "fetched; set the robot's sources and keyrings right first"
            )
        if "expired" in done.stderr or "not valid yet" in done.stderr:
            raise RemoteError("a source of the robot is out of date; check this machine's clock")
        if done.returncode:
            raise RemoteError(
                "no source of the robot answered, and nothing was collected before for it as it "
                "is now: connect this machine to a network once"
                if not re.search(r"404|403", done.stderr)
                else "a source of the robot answers but has no package list: check its sources"
            )

    def wanted(self, packages: list[str]) -> list[Wanted]:
        """Return what the robot lacks for some packages, with the index's own hashes."""
        done = self._get("--print-uris", "install", *packages)
        if unknown := UNKNOWN.search(done.stderr + done.stdout):
            name = unknown[1] or unknown[2]
            advice = "check its name and the robot's sources"
            raise InputError(
                f"no source of the robot has {name}", field="--packages", advice=advice
            )
        if done.returncode:
            raise BackendError(
                "apt finds no way to install these packages on the robot "
                f'({_reason(done.stderr + done.stdout)}): run "apt-get --fix-broken install" there'
            )
        lines = [line for line in done.stdout.splitlines() if line.startswith("'")]
        found = [
            Wanted(uri, cached, int(size), digest)
            for uri, cached, size, digest in URI.findall(done.stdout)
        ]
        if len(found) != len(lines):
            raise RemoteError("a source of the robot names packages without a SHA256: refused")
        return sorted(found, key=lambda deb: deb.name)

    def download(self, packages: list[str], wanted: list[Wanted], folder: Path) -> None:
        """Download them into a folder, every one held against the signed index."""
        done = self._get("--download-only", "install", *packages)
        if "Hash Sum mismatch" in done.stderr:
            raise RemoteError("a mirror sent other bytes than its signed index says: run it again")
        if done.returncode:
            raise RemoteError("not every package could be downloaded: run it again")
        for deb in wanted:
            path = self.root / "cache" / "archives" / deb.cached
            if deb.uri.startswith("file:"):  # on this machine's own disk: apt copies nothing
                path = Path("/" + unquote(deb.uri[5:]).lstrip("/"))
            copy = folder / deb.name
            if path.is_file():
                shutil.copyfile(path, copy)
            if not copy.is_file() or sha256(copy) != deb.sha256:
                raise RemoteError(
                    f"{deb.name}: its bytes are not those that the signed index names; it was not "
                    "kept: run it again"
                )

    def _get(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["apt-get", "-c", str(self.config), "--quiet=2", "--yes", "--no-upgrade", *words],
            env=os.environ | {"LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive"},
            capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL,
        )  # fmt: skip


def _reason(text: str) -> str:
    lines = [line for line in text.splitlines() if re.search(r"Depends:|unmet|held|broken", line)]
    return re.sub(r"\S*:/{2}\S*", "...", lines[-1].strip()) if lines else "it gave no reason"
