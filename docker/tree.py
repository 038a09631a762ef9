"""List a file tree: kind, mode, owner, hash and path of everything. Usage: tree.py ROOT >LIST

Times are left out: what matters is that the files are the same.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
from pathlib import Path


def entry(path: Path, root: Path) -> str:
    status = path.lstat()
    if stat.S_ISLNK(status.st_mode):
        content = "-> " + os.readlink(path)
    elif stat.S_ISREG(status.st_mode):
        with path.open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
    else:
        content = "-"
    mode, owner = stat.filemode(status.st_mode), f"{status.st_uid}:{status.st_gid}"
    return f"{path.relative_to(root)}\t{mode}\t{owner}\t{content}"


def main() -> None:
    root = Path(sys.argv[1])
    lines = [
        entry(Path(folder, name), root)
        for folder, folders, files in os.walk(root)
        for name in (*folders, *files)
    ]
    print("\n".join(sorted(lines)))
    print(hashlib.sha256("\n".join(sorted(lines)).encode()).hexdigest(), file=sys.stderr)


if __name__ == "__main__":
    main()
