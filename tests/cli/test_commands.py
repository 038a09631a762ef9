"""The command line as programs and people meet it: output, files, exit codes, one sentence."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
import started
from processes import await_text
from slow import slow

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
QUESTION = EXAMPLES / "paper-7-items.json"


def qrobot(
    *words: str | Path, cwd: str | Path = ".", env: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    return started.run(*words, folder=cwd, environment=env)


def one_sentence(done: subprocess.CompletedProcess[str]) -> str:
    # On a busy machine progress is shown before a refusal.
    said = done.stderr.strip().splitlines()
    lines = [line for line in said if not re.match(r"\s*[\d.]+ s  ", line)]
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("qrobot: ")
    assert "Traceback" not in done.stderr
    return lines[0]


def test_solve_prints_a_table_and_writes_a_plan_that_check_accepts(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    question = EXAMPLES / "paper-7-items.json"
    done = qrobot("solve", question, "-o", plan)
    assert done.returncode == 0, done.stderr
    assert "proven optimal" in done.stdout
    assert "stops in sequence" in done.stdout
    assert "written:" in done.stdout
    checked = qrobot("check", plan, question)
    assert checked.returncode == 0
    assert checked.stdout.startswith("right: ")


def test_json_is_all_that_is_printed() -> None:
    done = qrobot("solve", EXAMPLES / "paper-4-items.json", "--json")
    data = json.loads(done.stdout)
    assert data["schema"] == "qrobot.plan/1"
    assert data["result"]["is_optimal"] is True
    assert {"build", "run", "return", "decode", "polish", "total"} <= set(data["result"]["timing"])
    assert done.stderr == ""


def test_pictures_are_written(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    svg, png = tmp_path / "plan.svg", tmp_path / "plan.png"
    done = qrobot("solve", EXAMPLES / "paper-4-items.json", "-q", "-p", svg, "-p", png)
    assert done.returncode == 0, done.stderr
    assert svg.read_text().lstrip().startswith("<?xml")
    assert png.read_bytes().startswith(b"\x89PNG")


def test_check_finds_a_broken_plan(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    question = EXAMPLES / "paper-7-items.json"
    qrobot("solve", question, "-q", "-o", plan)
    data = json.loads(plan.read_text())
    lost = data["trips"][0]["stops"].pop()
    plan.write_text(json.dumps(data))
    done = qrobot("check", plan, question, "--json")
    assert done.returncode == 1
    report = json.loads(done.stdout)
    assert not report["ok"]
    assert any(lost in problem["text"] for problem in report["problems"])


def test_orders_in_csv_and_split_orders() -> None:
    done = qrobot("solve", EXAMPLES / "orders.csv", "--layout", EXAMPLES / "layout.json", "-t", "1")
    assert done.returncode == 0, done.stderr
    split = qrobot("solve", EXAMPLES / "orders.csv", "--split-orders", "-t", "1", "--json")
    assert json.loads(split.stdout)["split_orders"] is True


def test_robots_and_capacity_are_overridden() -> None:
    question = EXAMPLES / "paper-4-items.json"
    free = qrobot("solve", question, "--robots", "free", "--capacity", "8", "--json")
    assert free.returncode == 0, free.stderr
    assert all(trip["load"] <= 8 for trip in json.loads(free.stdout)["trips"])
    few = qrobot("solve", question, "--robots", "1", "--capacity", "8")
    assert few.returncode == 1
    assert "total load 22 exceeds 1 x 8" in one_sentence(few)


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["solve", "missing.json"], 2, "missing.json"),
        (["solve", "{empty}"], 2, "empty"),
        (["solve", "{example}", "--backend", "nonsense"], 2, "use one of: auto, exact"),
        (["solve", "{example}", "--backend", "nael"], 2, "did you mean neal? use one of: auto"),
        (["solve", "{example}", "--fallback", "nael"], 2, "fallback: 'nael' is not a backend"),
        (["solve", "{example}", "--output", "-"], 2, "use /dev/stdout"),
        (["solve", "{example}", "-o", "a.json", "-o", "./a.json"], 2, "is written twice"),
        (["solve", "{example}", "--deadline", "-1"], 2, "deadline"),
        (["solve", "{example}", "--deadline", "nan"], 2, "deadline: nan"),
        (["solve", "{example}", "--max-cost", "inf"], 2, "max_cost: inf"),
        (["solve", "{example}", "--robots", "1_0"], 2, "--robots"),
        (["solve", "{example}", "--robots", "\u0663"], 2, "--robots"),
        (["solve", "{example}", "-O", "dead_line=3"], 2, "did you mean deadline?"),
        (["solve", "{example}", "-b", "neal", "-O", "dead_line=3"], 2, "did you mean deadline?"),
        (["solve", "{example}", "-b", "neal", "-O", "num_sweep=3"], 2, "did you mean num_sweeps?"),
        (["solve", "{example}", "-b", "neal", "-O", "num_sweeps=0"], 2, "num_sweeps: 0 is not"),
        (["solve", "{example}", "-b", "neal", "-O", "rounds=0"], 2, "rounds: 0 is not"),
        (["solve", "{example}", "-b", "neal", "-O", "beta_range=[NaN,1]"], 2, "beta_range: NaN"),
        (
            ["solve", "{example}", "-b", "neal", "-O", "beta_range=[1,1e999]"],
            2,
            "beta_range: 1e999",
        ),
        (
            ["solve", "{example}", "-b", "neal", "-O", "num_reads=3", "--reads", "5"],
            2,
            "contradicts",
        ),
        (
            ["solve", "{example}", "-b", "neal", "-O", "num_reads=3", "-O", "num_reads=4"],
            2,
            "-O num_reads=4 contradicts -O num_reads=3",
        ),
        (["solve", "{example}", "-b", "tabu", "-O", "moves=abc"], 2, "moves: 'abc' is not a whole"),
        (["solve", "{example}", "-b", "tabu", "-O", "moves=null"], 2, "moves: None is not a whole"),
        (["solve", "{example}", "-b", "tabu", "-O", "timeout=-5"], 2, "timeout: -5 is not a whole"),
        (["solve", "{example}", "-b", "tabu", "-O", "timeout=true"], 2, "timeout: True is not"),
        (["solve", "{example}", "-b", "exact", "--control"], 2, "backend exact has no control"),
        (["jobs", "list", "--state", "over"], 2, "'over' is not one of"),
        (["solve", "{example}", "--robots", "many"], 2, "--robots"),
        (["solve", "{example}", "--capacity", "heavy"], 2, "capacity"),
        (["solve", "{example}", "--output", "no/such/folder/plan.json"], 2, "does not exist"),
        (["solve", "{example}", "--output", "{folder}"], 2, "is a folder"),
        (["solve", "{example}", "--picture", "plan.jpg"], 2, ".svg or .png"),
        (["check", "{example}", "{example}"], 2, "unknown schema"),
        (["check", "{empty}", "{example}"], 2, "empty"),
        (["solve", "{example}", "-o", "same.svg", "-p", "same.svg"], 2, "is written twice"),
        (["bench", "{examples}", "--json", "b.txt", "--csv", "b.txt"], 2, "is written twice"),
        (["bench", "{examples}", "--deadline", "nan"], 2, "--deadline"),
        (["bench", "{examples}", "--limit", "0"], 2, "--limit"),
        (["bench", "{examples}", "--backends", ","], 2, "no backend"),
        (["bench", "{folder}"], 2, "holds no"),
        (["bench", "missing-folder"], 2, "is not a folder"),
        (["bench", "{examples}", "--seeds", "0"], 2, "--seeds"),
        (["bench", "{examples}", "--robots-for", "X=many"], 2, "--robots-for"),
    ],
)
def test_wrong_use_gets_one_sentence(
    words: list[str], code: int, says: str, tmp_path: Path
) -> None:
    empty = tmp_path / "empty.json"
    empty.touch()
    folder = tmp_path / "folder"
    folder.mkdir()
    places = {
        "example": EXAMPLES / "paper-4-items.json",
        "examples": EXAMPLES,
        "empty": empty,
        "folder": folder,
    }
    words = [word.format(**places) if word[:1] == "{" else word for word in words]
    done = qrobot(*words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert says in (done.stderr if "jobs" in words else one_sentence(done))


def test_what_agrees_is_no_contradiction(tmp_path: Path) -> None:
    question = EXAMPLES / "paper-4-items.json"
    words = ("-b", "neal", "-O", "num_reads=3", "--reads", "3", "-O", "num_reads=3", "--json")
    one, two = tmp_path / "one.json", tmp_path / "two.json"
    done = qrobot("solve", question, *words, "-o", one, "-o", two)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["result"]["sampler"]["reads"] == 3
    assert json.loads(one.read_text()) == json.loads(two.read_text()) == json.loads(done.stdout)


@pytest.mark.parametrize("word", ["free", "FREE", "Free"])
def test_free_robots_however_it_is_written(word: str, tmp_path: Path) -> None:
    question = EXAMPLES / "paper-4-items.json"
    done = qrobot("solve", question, "--robots", word, "--capacity", "8", "--json")
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "one.json").write_text(question.read_text())
    done = qrobot("bench", folder, "--robots", word, "--robots-for", f"*={word}", "--max-work", "9")
    assert done.returncode == 0, done.stderr


def test_a_backend_that_tells_a_control_takes_the_flag() -> None:
    question = EXAMPLES / "paper-4-items.json"
    for backend in ("qaoa-swap", "qaoa-grover"):
        plain = qrobot("solve", question, "-b", backend, "--json")
        asked = qrobot("solve", question, "-b", backend, "--control", "--json")
        assert asked.returncode == 0, asked.stderr
        reports = [json.loads(done.stdout)["result"]["sampler"] for done in (plain, asked)]
        assert reports[0] == reports[1]
        assert reports[1]["random_best"] is not None


@pytest.mark.parametrize("words", [["-q"], ["--json"], ["-q", "--json"]])
def test_whose_answer_it_is_is_told_even_when_quiet(words: list[str], tmp_path: Path) -> None:
    question, plan = EXAMPLES / "paper-4-items.json", tmp_path / "plan.json"
    home = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path), "DWAVE_API_TOKEN": ""}
    asked = ("solve", question, "-b", "dwave-qpu", "--fallback", "exact", *words, "-o", plan)
    done = qrobot(*asked, env=home)
    assert done.returncode == 0, done.stderr
    assert "warning: dwave-qpu failed, exact answered instead" in one_sentence(done)
    assert json.loads(plan.read_text())["result"]["answered_by"] == "exact"
    if "--json" in words:
        assert json.loads(done.stdout)["result"]["answered_by"] == "exact"
    quiet = qrobot("solve", question, "-b", "exact", "--fallback", "batching", *words)
    assert quiet.stderr == ""


def test_a_wrong_option_is_told_by_click_with_code_2() -> None:
    done = qrobot("solve", "--no-such-option")
    assert done.returncode == 2
    assert "No such option" in done.stderr
    assert "Traceback" not in done.stderr


def test_debug_shows_the_traceback() -> None:
    done = qrobot("--debug", "solve", "missing.json")
    assert done.returncode != 0
    assert "Traceback" in done.stderr


def test_a_full_disk_is_one_sentence() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("/dev/full exists on Linux only")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "qrobot", "backends"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            cwd=ROOT,
        )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "No space left" in done.stderr


def test_output_into_a_small_full_file_system(tmp_path: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("mounting a small file system needs root")
    small = tmp_path / "small"
    small.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", str(small)], check=False
    )
    if mounted.returncode:
        pytest.skip("this machine does not allow mounting")
    try:
        (small / "plan.json").write_text("old")
        done = qrobot(
            "solve", EXAMPLES / "small-warehouse.json", "-t", "0.5", "-q", "-o", small / "plan.json"
        )
        assert done.returncode == 2
        assert "No space left" in one_sentence(done)
        assert (small / "plan.json").read_text() == "old"
        assert [p.name for p in small.iterdir()] == ["plan.json"]
    finally:
        subprocess.run(["umount", str(small)], check=True)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, slow(signal.SIGHUP)])
def test_an_interrupt_keeps_the_best_plan(number: signal.Signals, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    question = EXAMPLES / "small-warehouse.json"
    # The first with the processes that help, which have to end too.
    helpers = {} if number == signal.SIGINT else {"QROBOT_HELPERS": "0"}
    process = subprocess.Popen(
        [sys.executable, "-m", "qrobot", "solve", str(question), "-t", "3600", "-o", str(plan)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | helpers,
    )
    await_text(process.stderr, "distance")
    process.send_signal(number)
    out, _ = process.communicate()
    assert process.returncode == 0
    assert "interrupted: the best plan so far" in out
    assert qrobot("check", plan, question).returncode == 0


def test_a_killed_run_leaves_the_old_file(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    plan.write_text("old")
    process = subprocess.Popen(
        [
            sys.executable, "-m", "qrobot", "solve", str(EXAMPLES / "small-warehouse.json"),
            "-t", "3600", "-o", str(plan),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    await_text(process.stderr, "distance")
    process.kill()
    process.communicate()
    assert plan.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


def test_backends_are_listed() -> None:
    rows = {row["name"]: row for row in json.loads(qrobot("backends", "--json").stdout)}
    assert {"exact", "pyvrp", "batching", "neal", "tabu"} <= set(rows)
    assert rows["exact"]["proves"] is True
    assert rows["batching"]["extra"] is None
    assert "batching" in qrobot("backends").stdout


def test_a_missing_extra_is_one_sentence_with_code_3(tmp_path: Path) -> None:
    """A folder in front of site-packages hides PyVRP, as if it were not installed."""
    hidden = tmp_path / "pyvrp.py"
    hidden.write_text("raise ImportError('hidden')\n")
    done = qrobot(
        "solve", EXAMPLES / "paper-4-items.json", "-b", "pyvrp",
        env={"PYTHONPATH": f"{tmp_path}:{ROOT}"},
    )  # fmt: skip
    assert done.returncode == 3
    assert "pip install 'qrobot[planners]'" in one_sentence(done)


def test_bench_compares_and_keeps_rows(tmp_path: Path) -> None:
    for name in ("paper-4-items.json", "paper-7-items.json"):
        (tmp_path / name).write_text((EXAMPLES / name).read_text())
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "index.json").write_text(json.dumps([{"file": "paper-4-items.json", "value": 50}]))
    out, csv, md = (
        tmp_path / "o" / "out.json",
        tmp_path / "o" / "out.csv",
        tmp_path / "o" / "out.md",
    )
    out.parent.mkdir()
    done = qrobot(
        "bench", tmp_path, "--backends", "auto,batching", "-t", "0.5", "--seeds", "1",
        "--json", out, "--csv", csv, "--markdown", md,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr  # the broken instance is a row with an error
    rows = json.loads(out.read_text())["rows"]
    assert len(rows) == 6
    wanted = {
        "instance", "backend", "seed", "cost", "bound", "reference", "gap", "proven", "feasible",
        "seconds", "peak_mb",
    }  # fmt: skip
    assert all(wanted <= set(row) for row in rows)
    assert [row["error"] is not None for row in rows] == [True, True, False, False, False, False]
    four = [row for row in rows if row["instance"] == "paper-4-items"]
    assert all(row["gap"] == pytest.approx(row["cost"] / 50 - 1) for row in four)
    assert four[0]["proven"]
    assert 10 < four[0]["peak_mb"] < 1000
    assert csv.read_text().count("\n") == 7
    assert "| auto |" in md.read_text()


def test_help_has_examples_everywhere() -> None:
    for name in ("solve", "check", "backends", "bench"):
        done = qrobot(name, "--help")
        assert done.returncode == 0
        assert f"qrobot {name}" in done.stdout
        assert "Examples:" in done.stdout


def test_an_output_never_overwrites_the_question(tmp_path: Path) -> None:
    question = tmp_path / "mine.json"
    text = (EXAMPLES / "paper-4-items.json").read_text()
    question.write_text(text)
    done = qrobot("solve", question, "-o", question)
    assert done.returncode == 2
    assert "is an input" in one_sentence(done)
    assert question.read_text() == text
