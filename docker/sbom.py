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

from locks import MACHINES, ROBOTS, pins

NAMESPACE = uuid.UUID("0b6f3c5e-6a1c-5f0e-9d35-4d1f3f8a7c11")  # ours, drawn once


def python_packages(lock: str, arch: str) -> Iterator[Component]:
    """Yield the pins that hold on the target, with the hashes that the lock allows."""
    for pin in pins(lock, MACHINES[arch]):
        yield Component(
            name=pin.name,
            version=pin.version,
            type=ComponentType.LIBRARY,
            bom_ref=f"pypi/{pin.name}",
            purl=PackageURL("pypi", None, pin.name, pin.version),
            properties=[Property(name="qrobot:lock", value=value) for value in pin.hashes],
        )


def debian_packages(base: str, added: str) -> Iterator[Component]:
    """Yield the packages of the base image and those that were unpacked into it."""
    found = {}
    for block in base.split("\n\n"):
        fields = dict(
            line.split(": ", 1) for line in block.splitlines() if re.match(r"\w\S*: ", line)
        )
        if fields.get("Status", "").endswith(" installed"):
            found[fields["Package"]] = (fields["Version"], fields["Architecture"])
    for line in added.splitlines():  # what was unpacked lies over what the base image has
        name, version, arch = line.split()
        found[name] = (version, arch)
    for name, (version, arch) in sorted(found.items()):
        yield Component(
            name=name,
            version=version,
            type=ComponentType.LIBRARY,
            bom_ref=f"deb/{name}",
            purl=PackageURL("deb", "debian", name, version, {"arch": arch}),
        )


def main() -> None:
    profile, arch, target = sys.argv[1:]
    image = next(image for image, held in ROBOTS.items() if held == profile)
    text = Path("/source/_version.py").read_text()
    version = re.findall(r'^__version__ = "([^"]+)"', text, re.MULTILINE)[0]
    bom = Bom()
    bom.metadata.component = Component(
        name=f"qrobot-{image}",
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
