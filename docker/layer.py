"""Make a layer of a folder that uv has installed into: compiled, its programs in /usr/local/bin.

Usage: layer.py LAYER SITE
"""

from __future__ import annotations

import compileall
import os
import py_compile
import shutil
import sys
from pathlib import Path


def programs(tree: Path, site: Path) -> None:
    """Move programs to where they are looked for, and let the target's Python run them."""
    folder = tree / "usr/local/bin"
    folder.mkdir(parents=True, exist_ok=True)
    for program in sorted((site / "bin").glob("*")) if (site / "bin").is_dir() else []:
        if program.is_file():
            text = program.read_bytes()
            if text.startswith(b"#!") and b"python" in text.split(b"\n", 1)[0]:
                text = b"#!/usr/bin/python3\n" + text.split(b"\n", 1)[1]
            (folder / program.name).write_bytes(text)
            (folder / program.name).chmod(0o755)
    shutil.rmtree(site / "bin", ignore_errors=True)
    (site / ".lock").unlink(missing_ok=True)  # uv's own
    for note in site.glob("*.dist-info/uv_cache.json"):  # when it was built: another each time
        note.unlink()
        record = note.with_name("RECORD")
        lines = record.read_text().splitlines(keepends=True)
        record.write_text("".join(line for line in lines if "/uv_cache.json," not in line))
    if (site / "share").is_dir():  # JupyterLab's pages and kernels
        shutil.copytree(site / "share", tree / "usr/local/share", dirs_exist_ok=True)
        shutil.rmtree(site / "share")
    if (site / "etc").is_dir():
        shutil.copytree(site / "etc", tree / "usr/local/etc", dirs_exist_ok=True)
        shutil.rmtree(site / "etc")


def byte_compile(site: Path, place: str) -> None:
    """Compile everything; the same files whenever it is done."""
    compileall.compile_dir(
        site,
        quiet=2,  # some packages carry files that are no Python
        stripdir=site,
        prependdir=place,
        invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH,
        workers=os.cpu_count() or 1,
    )


def main() -> None:
    tree, site = sys.argv[1:]
    folder = Path(tree, site)
    programs(Path(tree), folder)
    byte_compile(folder, f"/{site}")


if __name__ == "__main__":
    main()
