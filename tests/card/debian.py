"""Debian's own programs, installed here or unpacked from their packages, to read our files with."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

PACKAGES = [  # of bookworm, and since trixie
    ["cloud-init", "netplan.io", "libnetplan0"],
    ["cloud-init", "netplan.io", "netplan-generator", "libnetplan1"],
]
SCHEMAS = "usr/lib/python3/dist-packages/cloudinit/config/schemas"
GENERATORS = ["usr/libexec/netplan/generate", "usr/lib/netplan/generate", "lib/netplan/generate"]


def unpacked(folder: Path) -> Path | None:
    """Return a root that has cloud-init, or None.

    `QROBOT_DEBIAN_ROOT` names one (of another release, say); otherwise it is this machine, or
    its packages are fetched by apt and unpacked, not installed.
    """
    if given := os.environ.get("QROBOT_DEBIAN_ROOT"):
        return Path(given)
    if (Path("/") / SCHEMAS).exists():
        return Path("/")
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb") and os.geteuid() == 0):
        return None
    folder.chmod(0o755)  # apt's own account reads it
    quick = ["-o", "Acquire::http::Timeout=10", "-o", "Acquire::Retries=0"]
    root = folder / "root"
    try:
        for packages in PACKAGES:
            words = ["apt-get", *quick, "-o", "APT::Sandbox::User=root", "download", *packages]
            done = subprocess.run(words, cwd=folder, capture_output=True, timeout=60, check=False)
            if done.returncode == 0:
                break
        for archive in folder.glob("*.deb"):
            subprocess.run(["dpkg-deb", "-x", archive, root], check=True, capture_output=True)
    except (subprocess.SubprocessError, OSError):
        return None
    return root if (root / SCHEMAS).exists() else None


def generator(root: Path) -> list[str | Path] | None:
    """Return the command of netplan's generator, with the libraries beside it, or None."""
    found = [root / name for name in GENERATORS if (root / name).exists()]
    if not found:
        return None
    if root == Path("/"):
        return [found[0]]
    loaders = sorted(root.glob("usr/lib/*/ld-linux-*.so.*"))
    libraries = sorted({path.parent for path in root.glob("usr/lib/*/libnetplan.so.*")})
    if loaders:  # a whole root of another release
        return [loaders[0], "--library-path", ":".join(map(str, libraries)), found[0]]
    return ["env", "LD_LIBRARY_PATH=" + ":".join(map(str, libraries)), found[0]]
