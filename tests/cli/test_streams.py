"""Every command with every state of its streams: the work is done, the code tells of the work."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile

import pytest
import started
from slow import slow

from qrobot.cli.signals import stop_on_signals, terminate_as_interrupt

ROOT = Path(__file__).resolve().parents[2]
QROBOT = [sys.executable, "-m", "qrobot"]
QUESTION = ROOT / "examples" / "paper-4-items.json"
KEY = "ssh-ed25519 AAAAC3NzaC1lZDI1NTE5AAAAIAABAgMEBQYHCAkKCwwNDg8QERITFBUWFxgZGhscHR4f me"

CLOSED = {
    "stdin closed": ("stdin",),
    "stdout closed": ("stdout",),
    "stderr closed": ("stderr",),
    "stdout and stderr closed": ("stdout", "stderr"),
    "all closed": ("stdin", "stdout", "stderr"),
}
SHUT = {"stdin": "<&-", "stdout": ">&-", "stderr": "2>&-"}
"""How a shell closes them."""
GONE = {
    "reader of stdout gone": ("stdout",),
    "reader of stderr gone": ("stderr",),
    "both readers gone": ("stdout", "stderr"),
}
FULL = {"disk of stdout full": ("stdout",), "disk of stderr full": ("stderr",)}
if not Path("/dev/full").exists():
    FULL.clear()
STATES = {
    "all": [*CLOSED, *GONE, *FULL],
    "some": ["stdout closed", "stderr closed", "both readers gone", *FULL],
    "few": ["all closed", "reader of stdout gone", *[state for state in FULL if "stdout" in state]],
}


@dataclass(frozen=True)
class Command:
    """Words, and the files that it writes below the folder it runs in."""

    words: str
    files: tuple[str, ...] = ()
    code: int | None = 0
    states: str = "some"


COMMANDS = [
    Command(f"solve {QUESTION} -o new.json", ("new.json",), states="all"),
    Command(f"solve {QUESTION} --json -o new.json -o again.json", ("new.json", "again.json")),
    Command(f"solve {QUESTION} -q -o new.json", ("new.json",)),
    Command(f"solve {QUESTION} --robots 1 --capacity 8", code=1),
    Command("solve missing.json", code=2),
    Command(f"solve {QUESTION} --dry-run"),
    Command(f"next {QUESTION}", states="few"),
    Command(f"next {QUESTION} --json", states="few"),
    Command(f"check plan.json {QUESTION}", states="all"),
    Command(f"check plan.json {QUESTION} --json"),
    Command(f"schedule plan.json {QUESTION} -o s.csv", ("s.csv",), states="few"),
    Command(f"ways plan.json {QUESTION} -o w.geojson", ("w.geojson",), states="few"),
    Command(f"check wrong.json {QUESTION}", code=1),
    Command("check missing.json missing.json", code=2),
    Command(f"export {QUESTION} model.coo", ("model.coo",)),
    Command(f"export {QUESTION} model.coo --json", ("model.coo",)),
    Command(
        "bench questions --max-work 9 --json b.json --csv b.csv", ("b.json", "b.csv"), states="few"
    ),
    Command("backends"),
    Command("backends --json"),
    Command("doctor", code=None),
    Command("doctor --json", code=None, states="few"),
    Command("jobs list"),
    Command("jobs fetch nothing", code=2, states="few"),
    Command("health --list --json", states="few"),
    Command("health --schema", states="few"),
    Command("health numpy --no-system -o h.json --junit h.xml", ("h.json", "h.xml"), states="few"),
    Command("image seed card --hostname robot-1 --user mira --key key.pub", ("card/user-data",)),
    Command("--help"),
    Command("--version", states="few"),
    Command("solve --help", states="few"),
    Command("solve --no-such-option", code=2),
    Command("no-such-command", code=2, states="few"),
]
STUDY = Command(
    "reproduce table2 --rows 2 --quick --reads 20 -o rows", ("rows/reproduce.json",), states="few"
)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A right plan, a wrong one, and what else the commands read."""
    folder = tmp_path_factory.mktemp("made")
    plan = folder / "plan.json"
    subprocess.run([*QROBOT, "solve", QUESTION, "-q", "-o", plan], check=True, cwd=ROOT)
    data = json.loads(plan.read_text())
    data["trips"][0]["stops"].pop()
    (folder / "wrong.json").write_text(json.dumps(data))
    (folder / "key.pub").write_text(f"{KEY}\n")
    (folder / "questions").mkdir()
    (folder / "questions" / "one.json").write_text(QUESTION.read_text())
    return folder


def folder_with(made: Path, place: Path) -> Path:
    place.mkdir()
    (place / "card").mkdir()
    for one in made.iterdir():
        (place / one.name).symlink_to(one)
    return place


def run(command: Command, folder: Path, state: str) -> subprocess.CompletedProcess[bytes]:
    """Run a command with its streams in a state; what is still a pipe is read.

    Those that meet all states are started with them, the others forked.
    """
    if command.states != "all":
        return forked(command, folder, state)
    streams: dict[str, object] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    opened = []
    for name in GONE.get(state, ()):
        reading, writing = os.pipe()
        os.close(reading)
        streams[name] = writing
        opened.append(writing)
    for name in FULL.get(state, ()):
        opened.append(os.open("/dev/full", os.O_WRONLY))
        streams[name] = opened[-1]
    try:
        return subprocess.run(
            [
                "sh",
                "-c",
                f'exec "$@" {" ".join(SHUT[name] for name in CLOSED.get(state, ()))}',
                "sh",
                *QROBOT,
                *command.words.split(),
            ],
            check=False,
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(ROOT), "XDG_STATE_HOME": str(folder / "state")},
            **streams,  # type: ignore[call-overload]
        )
    finally:
        for number in opened:
            os.close(number)


def forked(command: Command, folder: Path, state: str) -> subprocess.CompletedProcess[bytes]:
    """Do the same as `run` in a process that need not import anything."""
    with TemporaryFile() as out, TemporaryFile() as err, open(os.devnull) as nothing:
        streams = {"stdin": nothing.fileno(), "stdout": out.fileno(), "stderr": err.fileno()}
        opened = []
        for name in GONE.get(state, ()):
            reading, streams[name] = os.pipe()
            os.close(reading)
            opened.append(streams[name])
        for name in FULL.get(state, ()):
            streams[name] = os.open("/dev/full", os.O_WRONLY)
            opened.append(streams[name])
        begun = started.start(
            command.words.split(),
            {n: number for n, number in streams.items() if n not in CLOSED.get(state, ())},
            folder=folder,
            environment=os.environ | {"XDG_STATE_HOME": str(folder / "state")},
        )
        for number in opened:
            os.close(number)
        code = begun.wait()
        out.seek(0)
        err.seek(0)
        return subprocess.CompletedProcess(command.words, code, out.read(), err.read())


@pytest.mark.parametrize(
    "command",
    [*COMMANDS, pytest.param(STUDY, marks=pytest.mark.slow)],
    ids=lambda one: " ".join(one.words.split()[:4])[-60:],
)
def test_streams_never_cost_the_work_nor_its_code(
    command: Command, made: Path, tmp_path: Path
) -> None:
    plain = run(command, folder_with(made, tmp_path / "plain"), "")
    assert command.code in (None, plain.returncode), plain.stderr.decode()
    for state in STATES[command.states]:
        folder = folder_with(made, tmp_path / state)
        done = run(command, folder, state)
        told = f"{state}: {done.stdout!r} {done.stderr!r}"
        if state == "disk of stdout full" and plain.stdout:
            assert done.returncode == 2, told
            lines = done.stderr.decode().splitlines()
            assert "No space left" in lines[-1], told
            assert lines[-1].startswith("qrobot: "), told
        else:
            assert done.returncode == plain.returncode, told
        assert b"Traceback" not in (done.stdout or b"") + (done.stderr or b""), told
        assert b"Exception" not in (done.stderr or b""), told
        for file in command.files:
            assert (folder / file).stat().st_size, f"{file} is missing: {told}"
            if file.endswith(".json"):
                json.loads((folder / file).read_text())


@pytest.mark.parametrize("state", ["", *map(slow, STATES["all"])])
def test_a_forked_command_does_what_a_started_one_does(
    state: str, made: Path, tmp_path: Path
) -> None:
    command = Command(f"check wrong.json {QUESTION}", states="all")
    one = run(command, folder_with(made, tmp_path / "started"), state)
    other = forked(command, folder_with(made, tmp_path / "forked"), state)
    assert other.returncode == one.returncode
    # What is not read, or not kept, differs.
    for text, same in ((one.stdout or b"", other.stdout), (one.stderr or b"", other.stderr)):
        assert text in (same, b"")


# -- encodings --------------------------------------------------------------------------------

ENCODINGS = ["ascii", "latin-1", "cp1252", "cp437", "utf-16", "euc_jp", "utf-8"]
NAMES = ["Schraube Ø", "Ångström €", "عربي", "日本語の棚", "😀", "\u00e1", 'quote"back\\slash']


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An instance whose names no single old encoding has."""
    path = tmp_path_factory.mktemp("foreign") / "foreign.json"
    document = json.loads(QUESTION.read_text())
    first = document["items"][0]
    document["name"] = "Lager Süd 倉庫"
    document["items"] = [first | {"id": name, "weight": 1} for name in NAMES]
    document.pop("orders", None)
    path.write_text(json.dumps(document))
    return path


def encoded(encoding: str, *words: str | Path) -> tuple[int, str, str]:
    """Run a command: a Python is started for two of the encodings, for the others it is forked."""
    setting = os.environ | {"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding}
    with TemporaryFile() as out, TemporaryFile() as err, open(os.devnull) as nothing:
        if encoding in {"ascii", "utf-16"}:
            command = [*QROBOT, *map(str, words)]
            code = subprocess.run(
                command, stdout=out, stderr=err, check=False, env=setting
            ).returncode
        else:
            streams = {"stdin": nothing.fileno(), "stdout": out.fileno(), "stderr": err.fileno()}
            code = started.start(words, streams, environment=setting).wait()
        out.seek(0)
        err.seek(0)
        said, told = out.read(), err.read()
    assert b"Traceback" not in told
    return code, said.decode(encoding), told.decode(encoding)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_json_is_the_same_in_every_encoding(encoding: str, foreign: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    code, text, _ = encoded(encoding, "solve", foreign, "--json", "-o", plan)
    assert code == 0
    trips = json.loads(text)["trips"]
    assert sorted(stop for trip in trips for stop in trip["stops"]) == sorted(NAMES)
    assert trips == json.loads(plan.read_text())["trips"]
    data = json.loads(plan.read_text())
    lost = data["trips"][0]["stops"].pop()
    plan.write_text(json.dumps(data))
    code, text, _ = encoded(encoding, "check", plan, foreign, "--json")
    assert code == 1
    assert any(lost in problem["text"] for problem in json.loads(text)["problems"])


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_tables_come_in_every_encoding(encoding: str, foreign: Path, tmp_path: Path) -> None:
    for question, expected in ((foreign, 0), (tmp_path / "Ø日.json", 2)):
        code, table, told = encoded(encoding, "solve", question)
        assert code == expected
        assert any(sign in table + told for sign in ("日", "\\u65e5"))


@pytest.mark.skipif(sys.platform != "linux", reason="file names are bytes on Linux only")
def test_a_file_name_that_is_no_text_is_written_and_told(tmp_path: Path) -> None:
    plan = os.fsencode(tmp_path) + b"/pl\xffan.json"
    for words in ([], ["--json"]):
        done = subprocess.run(
            [*QROBOT, "solve", QUESTION, "-o", plan, *words], capture_output=True, check=False
        )
        assert done.returncode == 0, done.stderr
        with open(plan, "rb") as file:
            assert json.load(file)["schema"] == "qrobot.plan/1"
    done = subprocess.run(
        [*QROBOT, "check", os.fsencode(tmp_path) + b"/no\xff.json", QUESTION],
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert b"check the path" in done.stderr


def test_a_pipe_that_does_not_block_gets_everything() -> None:
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    process = subprocess.Popen([*QROBOT, "health", "--schema"], stdout=writing, cwd=ROOT)
    os.close(writing)
    with os.fdopen(reading, "rb") as file:
        text = file.read()
    assert process.wait() == 0
    assert json.loads(text)["$schema"]


# -- a connection that is lost ----------------------------------------------------------------


def test_a_terminal_that_hangs_up_leaves_the_plan(tmp_path: Path) -> None:
    plan, question = tmp_path / "plan.json", ROOT / "examples" / "small-warehouse.json"
    child, terminal = pty.fork()
    if not child:
        words = [*QROBOT, "solve", str(question), "-t", "120", "-o", str(plan)]
        alone = {"PYTHONPATH": str(ROOT), "QROBOT_HELPERS": "0"}
        os.execve(words[0], words, os.environ | alone)
    told = b""
    while b"distance" not in told:
        told += os.read(terminal, 1000)
    os.close(terminal)  # as when the Wi-Fi is gone: SIGHUP, and nowhere to write
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    done = subprocess.run([*QROBOT, "check", plan, question], check=False, cwd=ROOT)
    assert done.returncode == 0


def test_further_hangups_of_one_lost_connection_do_not_kill() -> None:
    with stop_on_signals() as stop:
        for _ in range(3):
            os.kill(os.getpid(), signal.SIGHUP)
        assert stop.requested
    with terminate_as_interrupt() as came:
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGHUP)
        os.kill(os.getpid(), signal.SIGHUP)  # while what was interrupted tidies up
        assert came()


@pytest.mark.parametrize("handling", [stop_on_signals, terminate_as_interrupt])
def test_a_hangup_that_nohup_ignores_stays_ignored(handling: object) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with handling() as asked:  # type: ignore[operator]
            os.kill(os.getpid(), signal.SIGHUP)
            assert not (asked.requested if handling is stop_on_signals else asked())
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    "words",
    [
        "bench questions --json one.json --json two.json",
        "jobs fetch some --plan one.json --plan two.json",
        f"export {QUESTION} --circuit one.qasm --circuit two.qasm",
        "health --list --html one.html --html two.html",
        "health merge a.json --html one.html --html two.html",
        "reproduce figure4 -o one -o two",
    ],
)
def test_a_file_that_would_not_be_written_is_refused(words: str, tmp_path: Path) -> None:
    done = run(Command(words), tmp_path, "")
    assert done.returncode == 2
    assert b"is given 2 times (one" in done.stderr
    assert not list(tmp_path.iterdir())
