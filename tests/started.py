"""Starts of a program that cost a fork in place of a Python with all its imports.

One process per test worker and program, with one thread, has imported what the program imports. For
each start it forks: a real process with descriptors, folder, environment, signals and exit code of
its own. What a test says about the start itself wants ``python -m qrobot`` (`REAL`).
"""

from __future__ import annotations

import array
import atexit
import contextlib
import gc
import importlib
import io
import json
import os
import select
import selectors
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

__all__ = ["QROBOT", "REAL", "Program", "Started", "door", "hand_over", "run", "start"]

ROOT = Path(__file__).resolve().parents[1]
REAL = (sys.executable, "-m", "qrobot")
STREAMS = ("stdin", "stdout", "stderr")


@dataclass(frozen=True)
class Program:
    """What is started.

    Attributes
    ----------
    name
        As it is called.
    command
        Its function, as ``module:function``.
    imports
        What it imports, but for what starts threads.
    environment
        What its imports read, which is then the same for every start; ``{folder}`` is a folder that
        is there as long as the process that forks.
    """

    name: str
    command: str
    imports: tuple[str, ...] = ()
    environment: Mapping[str, str] = field(default_factory=dict, hash=False)


QROBOT = Program("qrobot", "qrobot.cli.main:main", (
    "qrobot.cli.solve", "qrobot.cli.check", "qrobot.cli.next",
    "qrobot.problem.formats.native", "qrobot.planning.solving", "qrobot.backends.classical.exact",
    "qrobot.backends.classical.batching", "qrobot.report", "qrobot.health", "dimod",
))  # fmt: skip


# -- the process that forks ----------------------------------------------------------------------


def serve(number: int, door: int, command: str, *imports: str) -> None:
    """Fork for every message that comes; in the child only, run the command.

    Messages come from the parent over a socket, and from other processes over another (`door`)
    that listens.
    """
    module, _, function = command.partition(":")
    main = getattr(importlib.import_module(module), function)
    for name in imports:
        importlib.import_module(name)
    gc.freeze()  # a collection would touch, so copy, all of it
    requests, visitors = socket.socket(fileno=number), socket.socket(fileno=door)
    while True:
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            pass
        asking = select.select([requests, visitors], [], [])[0][0]
        connection = requests if asking is requests else visitors.accept()[0]
        message, descriptors = _receive(connection)
        if connection is not requests:
            connection.close()
        elif not message:
            os._exit(0)
        if message and os.fork() == 0:
            requests.close()
            visitors.close()
            _keep(json.loads(message), descriptors)
            run_to_end(main)
        for descriptor in descriptors:
            os.close(descriptor)


def _keep(asked: dict[str, Any], descriptors: list[int]) -> None:
    """Fork the command, tell its number and its end; return in the command's process."""
    reply = socket.socket(fileno=descriptors[0])
    child = os.fork()
    if child == 0:
        reply.close()
        return _become(asked, dict(zip(asked["streams"], descriptors[1:], strict=True)))
    for descriptor in descriptors[1:]:
        os.close(descriptor)
    reply.sendall(f"{child}\n".encode())
    _, status = os.waitpid(child, 0)
    reply.sendall(f"{os.waitstatus_to_exitcode(status)}\n".encode())
    os._exit(0)


def _become(asked: dict[str, Any], streams: dict[str, int]) -> None:
    """Take on what was asked for, as the start of a Python does."""
    for number, name in enumerate(STREAMS):
        if name not in streams:
            os.close(number)
        else:
            os.dup2(streams[name], number)
    for descriptor in streams.values():
        os.close(descriptor)
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    tempfile.tempdir = None  # as the environment says
    time.tzset()
    sys.argv = asked["words"]
    for number, name in enumerate(STREAMS):
        stream = _stream(number, name) if name in streams else None
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _stream(number: int, name: str) -> io.TextIOWrapper:
    """Return a descriptor as the text stream that Python makes of it."""
    raw = io.FileIO(number, "r" if name == "stdin" else "w", closefd=False)
    binary = io.BufferedReader(raw) if name == "stdin" else io.BufferedWriter(raw)
    errors = "backslashreplace" if name == "stderr" else "strict"
    line = name == "stderr" or os.isatty(number)
    encoding = os.environ.get("PYTHONIOENCODING", "utf-8")
    return io.TextIOWrapper(binary, encoding, errors, line_buffering=line)


def _receive(connection: socket.socket) -> tuple[bytes, list[int]]:
    size = array.array("i").itemsize
    head, descriptors, _, _ = socket.recv_fds(connection, 8, 4 * size)
    message = b""
    wanted = int.from_bytes(head, "big")
    while len(message) < wanted:
        message += connection.recv(wanted - len(message))
    return message, list(descriptors)


# -- those who start ------------------------------------------------------------------------------


class Started:
    """A command that runs."""

    def __init__(self, reply: socket.socket) -> None:
        self._reply = reply.makefile("r")
        reply.close()
        self.pid = self._number()

    def wait(self) -> int:
        """Return its exit code, or minus the signal that ended it, when it has ended."""
        code = self._number()
        self._reply.close()
        return code

    def _number(self) -> int:
        line = self._reply.readline()
        assert line, "the process that forks has ended; what it said stands on the standard error"
        return int(line)


def start(
    words: Sequence[object],
    streams: Mapping[str, int],
    *,
    folder: str | Path = ".",
    environment: Mapping[str, str] | None = None,
    program: Program = QROBOT,
) -> Started:
    """Start a program with words.

    Parameters
    ----------
    words
        Its arguments.
    streams
        Descriptors by name; a stream that is missing is closed.
    folder, environment
        Those of the command; by default of this process.
    program
        What is started.
    """
    given = os.environ if environment is None else environment
    words = [program.name, *words]
    return _ask(_forker(program)[0], words, streams, str(Path(folder).resolve()), given)


def _ask(
    requests: socket.socket,
    words: Sequence[object],
    streams: Mapping[str, int],
    folder: str,
    environment: Mapping[str, str],
) -> Started:
    here, there = socket.socketpair()
    asked = {
        "words": list(map(str, words)),
        "streams": list(streams),
        "folder": folder,
        "environment": dict(environment),
    }
    message = json.dumps(asked).encode()
    socket.send_fds(
        requests, [len(message).to_bytes(8, "big")], [there.fileno(), *streams.values()]
    )
    requests.sendall(message)
    there.close()
    return Started(here)


def hand_over(words: Sequence[str], door: str) -> NoReturn:
    """Let the process behind a door run a command in place of this one, and end with its code."""
    with socket.socket(socket.AF_UNIX) as visitor:
        visitor.connect(door)
        streams = {name: number for number, name in enumerate(STREAMS)}
        started = _ask(visitor, [QROBOT.name, *words], streams, str(Path.cwd()), os.environ)
    code = started.wait()
    os._exit(code if code >= 0 else 128 - code)


def run(
    *words: object,
    folder: str | Path = ".",
    environment: Mapping[str, str] | None = None,
    given: str = "",
    program: Program = QROBOT,
    alone: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end and return its code and what it said.

    Where the environment holds what only the start of a Python reads, a Python is started.

    Parameters
    ----------
    words, folder
        As of `start`.
    environment
        What is added to that of this process, or all there is where it stands `alone`.
    given
        What it reads, at most 64 KiB.
    program
        What is run.
    alone
        Whether the environment is all.
    """
    added = dict(environment or {})
    environment = added if alone else os.environ | added
    if program is QROBOT and any(name.startswith("PYTHON") for name in added):
        environment.setdefault("PYTHONPATH", str(ROOT))
        return subprocess.run(
            [*REAL, *map(str, words)], cwd=folder, env=environment, input=given,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    pipes = {name: os.pipe() for name in STREAMS}
    theirs = {name: ends[name != "stdin"] for name, ends in pipes.items()}
    started = start(words, theirs, folder=folder, environment=environment, program=program)
    for number in theirs.values():
        os.close(number)
    with contextlib.suppress(BrokenPipeError):  # it ended without reading
        os.write(pipes["stdin"][1], given.encode())
    os.close(pipes["stdin"][1])
    said = _read({name: pipes[name][0] for name in ("stdout", "stderr")})
    code = started.wait()
    return subprocess.CompletedProcess(list(map(str, words)), code, said["stdout"], said["stderr"])


def _read(pipes: dict[str, int]) -> dict[str, str]:
    """Return all that comes out of pipes, read side by side."""
    said: dict[str, bytes] = dict.fromkeys(pipes, b"")
    with selectors.DefaultSelector() as waiting:
        for name, number in pipes.items():
            waiting.register(number, selectors.EVENT_READ, name)
        while waiting.get_map():
            for key, _ in waiting.select():
                part = os.read(key.fd, 65536)
                said[key.data] += part
                if not part:
                    waiting.unregister(key.fd)
                    os.close(key.fd)
    return {name: text.decode(errors="surrogateescape") for name, text in said.items()}


_known: dict[Program, tuple[socket.socket, str]] = {}


def door() -> str:
    """Return where other processes find the process that forks."""
    return _forker(QROBOT)[1]


def _forker(program: Program) -> tuple[socket.socket, str]:
    """Return the way to the process that forks, which is started once, and its door."""
    if program not in _known:
        here, there = socket.socketpair()
        folder = tempfile.mkdtemp()
        path = f"{folder}/door"
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind(path)
            listening.listen()
            numbers = [there.fileno(), listening.fileno()]
            process = subprocess.Popen(
                [sys.executable, "-c",
                 f"import started; started.serve(*{[*numbers, program.command, *program.imports]})",
                 "the process that forks"],
                pass_fds=numbers, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "tests"), *sys.path])}
                | {name: text.format(folder=folder) for name, text in program.environment.items()},
            )  # fmt: skip
        there.close()
        _known[program] = here, path

        def close() -> None:
            here.close()
            process.wait()
            shutil.rmtree(folder)

        atexit.register(close)
    return _known[program]


def run_to_end(command: Callable[[], object]) -> NoReturn:
    """Run a command line in a process that was forked for it, and end as Python does.

    Only the modules are not taken apart: that would copy all memory that the fork shares.
    """
    try:
        command()
        code = 0
    except SystemExit as done:
        code = done.code if isinstance(done.code, int) else 0
    except BaseException:
        traceback.print_exc()
        code = 1
    vars(threading)["_shutdown"]()  # ends pools of threads too, which wait for work until told
    atexit._run_exitfuncs()  # nothing public runs them without the end of the interpreter
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            code = 120
    os._exit(code)
