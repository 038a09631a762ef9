"""What the controller's programs share: one sentence an error, whole files, one at a time.

They run as files of this folder, by a Python that has qRobot (`make install`), or with the checkout
on PYTHONPATH, as the playbooks do it.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from qrobot._files import replace_file
from qrobot.errors import QRobotError

ROOT = Path(__file__).resolve().parents[2]


def say(text: str) -> None:
    """Write a line of progress: stdout is for the result alone."""
    print(text, file=sys.stderr, flush=True)


def sha256(path: Path) -> str:
    """Return the sha256 of a file as 64 hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_json(path: Path) -> Any:
    """Return what a file of ours holds, or nothing when it is not there or was cut short."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def write_json(path: Path, document: Any) -> None:
    """Write a file that is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(document, indent=1, sort_keys=True) + "\n"
    replace_file(path, text.encode())


@contextlib.contextmanager
def lock_folder(folder: Path, who: str) -> Iterator[None]:
    """Hold a folder while one program works in it; a second one waits. Ends with the process."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say(f"{who}: waiting for another one that works in {folder}")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def run(who: str, main: Callable[[], None]) -> int:
    """Run a program: the exit code, and one sentence where it cannot do its work.

    Codes: 0 done, 2 something it was given cannot be used, 3 something did not answer as it should.
    """
    try:
        main()
    except QRobotError as error:
        say(f"{who}: {error}")
        return error.exit_code
    except OSError as error:
        say(f"{who}: {error.filename or 'a file'}: {error.strerror or error}")
        return 3
    except KeyboardInterrupt:
        say(f"{who}: stopped; what is complete is kept, run it again to go on")
        return 3
    return 0
