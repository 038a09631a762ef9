"""List what an image holds as CycloneDX: the lock's packages, Debian's, and qRobot.

Usage: sbom.py PROFILE ARCH FILE

Runs while an image is built. The same input gives the same bytes: the serial number is made of
the content and the time is SOURCE_DATE_EPOCH.
"""

from __future__ import annotations

import os
import re
import sys
import uuid
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from cyclonedx.model import Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

MACHINE = {"amd64": "x86_64", "arm64": "aarch64"}
PIN = re.compile(r"^(?P<requirement>[A-Za-z0-9][^\\#]*==[^\\#]*)", re.MULTILINE)
HASH = re.compile(r"--hash=(sha256:[0-9a-f]{64})")
NAMESPACE = uuid.UUID("0b6f3c5e-6a1c-5f0e-9d35-4d1f3f8a7c11")  # ours, drawn once


def python_packages(lock: str, arch: str) -> Iterator[Component]:
    """Yield the pins that hold on the target, with the hashes that the lock allows."""
    version = f"{sys.version_info[0]}.{sys.version_info[1]}"
    environment = {
        "python_version": version,
        "python_full_version": f"{version}.0",
        "platform_machine": MACHINE[arch],
        "platform_system": "Linux",
        "sys_platform": "linux",
        "os_name": "posix",
        "implementation_name": "cpython",
        "platform_python_implementation": "CPython",
    }
    starts = [*PIN.finditer(lock)]
    ends = [match.start() for match in starts[1:]] + [len(lock)]
    for match, end in zip(starts, ends, strict=True):
        pin = Requirement(match["requirement"].strip())
        if pin.marker and not pin.marker.evaluate(environment):
            continue
        name = canonicalize_name(pin.name)
        number = next(iter(pin.specifier)).version
        yield Component(
            name=name,
            version=number,
            type=ComponentType.LIBRARY,
            bom_ref=f"pypi/{name}",
            purl=PackageURL("pypi", None, name, number),
            properties=[
                Property(name="qrobot:lock", value=value)
                for value in HASH.findall(lock[match.start() : end])
            ],
        )


def debian_packages(base: str, added: str) -> Iterator[Component]:
    """Yield the packages of the base image and those that were unpacked into it."""
    found = [tuple(line.split()) for line in added.splitlines()]
    for block in base.split("\n\n"):
        fields = dict(
            line.split(": ", 1) for line in block.splitlines() if re.match(r"\w\S*: ", line)
        )
        if fields.get("Status", "").endswith(" installed"):
            found.append((fields["Package"], fields["Version"], fields["Architecture"]))
    for name, version, arch in sorted(found):
        yield Component(
            name=name,
            version=version,
            type=ComponentType.LIBRARY,
            bom_ref=f"deb/{name}",
            purl=PackageURL("deb", "debian", name, version, {"arch": arch}),
        )


def main() -> None:
    profile, arch, target = sys.argv[1:]
    version = re.findall(r'"([^"]+)"', Path("/source/_version.py").read_text())[-1]
    bom = Bom()
    bom.metadata.component = Component(
        name=f"qrobot-{ {'full': 'lab'}.get(profile, profile) }",
        version=version,
        type=ComponentType.CONTAINER,
        bom_ref="image",
        properties=[Property(name="qrobot:architecture", value=f"linux/{arch}")],
    )
    bom.metadata.timestamp = datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC)
    parts = [
        *python_packages(Path(f"/locks/{profile}.txt").read_text(), arch),
        *debian_packages(Path("/base/status").read_text(), Path("/packages").read_text()),
        Component(
            name="qrobot",
            version=version,
            type=ComponentType.LIBRARY,
            bom_ref="pypi/qrobot",
            purl=PackageURL("pypi", None, "qrobot", version),
        ),
    ]
    bom.components.update(parts)
    bom.register_dependency(bom.metadata.component, parts)
    names = ",".join(str(part.purl) for part in parts)
    bom.serial_number = uuid.uuid5(NAMESPACE, f"{profile} {arch} {names}")
    Path(target).write_text(JsonV1Dot6(bom).output_as_string(indent=1) + "\n")


if __name__ == "__main__":
    main()
