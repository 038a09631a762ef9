"""How commands behave when they are interrupted, cut off or asked for more."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import psutil
import pytest
from processes import await_text, gone, until
from slow import slow

from qrobot.cli import main

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
QROBOT = [sys.executable, "-m", "qrobot"]


def start(*words: str | Path, **options: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*QROBOT, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        **options,  # type: ignore[call-overload]
    )


def code_of(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as done:
        main([str(word) for word in words])
    return int(done.value.code or 0)


@pytest.mark.parametrize("number", [signal.SIGINT, slow(signal.SIGTERM), slow(signal.SIGHUP)])
def test_an_interrupted_bench_keeps_its_rows(number: signal.Signals, tmp_path: Path) -> None:
    folder = tmp_path / "questions"
    folder.mkdir()
    for name in ("paper-4-items.json", "small-warehouse.json"):
        (folder / name).write_text((EXAMPLES / name).read_text())
    out, table = tmp_path / "out.json", tmp_path / "out.csv"
    process = start("bench", folder, "-t", "3600", "--json", out, "--csv", table)
    await_text(process.stderr, "paper-4-items")
    process.send_signal(number)
    _, told = process.communicate()
    assert process.returncode == 130
    assert "1 of 2 runs are kept" in told
    assert "Traceback" not in told
    report = json.loads(out.read_text())
    assert report["interrupted"] is True
    assert [row["instance"] for row in report["rows"]] == ["paper-4-items"]
    assert table.read_text().count("\n") == 2


def test_a_killed_bench_leaves_nobody_behind(tmp_path: Path) -> None:
    folder = tmp_path / "questions"
    folder.mkdir()
    name = "small-warehouse.json"
    (folder / name).write_text((EXAMPLES / name).read_text())
    process = start("bench", folder, "-t", "3600")
    bench = psutil.Process(process.pid)
    until(lambda: bench.children(recursive=True), "bench starts nobody")
    workers = bench.children(recursive=True)
    process.kill()
    process.communicate()
    assert all(gone(worker.pid) for worker in workers)


def test_the_second_interrupt_aborts(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    process = start("solve", EXAMPLES / "small-warehouse.json", "-t", "3600", "-o", plan)
    await_text(process.stderr, "distance")
    process.send_signal(signal.SIGSTOP)  # both arrive before it can answer the first
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGTERM)
    process.send_signal(signal.SIGCONT)
    process.communicate()
    # The first ends the search; whether the second still meets it is a matter of luck.
    assert process.returncode in {0, 130, -signal.SIGTERM}
    assert not plan.exists() or json.loads(plan.read_text())["schema"] == "qrobot.plan/1"
    assert [p.name for p in tmp_path.iterdir()] in ([], ["plan.json"])


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [*QROBOT, "solve", str(EXAMPLES / "paper-4-items.json"), "--json", "-o", str(plan)],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    os.close(writing)
    assert done.returncode == 0
    assert done.stderr == ""
    assert plan.exists()


@pytest.mark.parametrize("where", ["first", "last"])
def test_debug_works_wherever_it_stands(where: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["solve", "missing.json"]
    words = ["--debug", *words] if where == "first" else [*words, "--debug"]
    assert code_of(*words) == 2
    told = capsys.readouterr().err
    assert "Traceback" in told
    assert told.splitlines()[-1].startswith("qrobot: ")


def test_a_plan_of_split_orders_is_right_only_where_splitting_was_allowed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, orders = tmp_path / "plan.json", EXAMPLES / "orders.csv"
    assert code_of("solve", orders, "--split-orders", "-t", "0.3", "-q", "-o", plan) == 0
    assert code_of("check", plan, orders, "--split-orders") == 0
    capsys.readouterr()
    assert code_of("check", plan, orders) == 1
    assert "split: the plan was made with split orders" in capsys.readouterr().out


def test_a_picture_without_matplotlib_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    plan = tmp_path / "plan.json"
    words = ("solve", EXAMPLES / "paper-4-items.json", "-o", plan, "-p", tmp_path / "p.svg")
    assert code_of(*words) == 3
    assert "pip install 'qrobot[plot]'" in capsys.readouterr().err
    assert not plan.exists()


def test_a_file_that_may_not_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may write everything")
    plan = tmp_path / "plan.json"
    plan.write_text("old")
    plan.chmod(0o444)
    assert code_of("solve", "missing.json", "-o", plan) == 2


def test_a_full_device_costs_the_file_but_not_the_plan(
    capsys: pytest.CaptureFixture[str],
) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("/dev/full exists on Linux only")
    assert code_of("solve", EXAMPLES / "paper-4-items.json", "--json", "-o", "/dev/full") == 2
    told = capsys.readouterr()
    assert json.loads(told.out)["result"]["is_optimal"] is True
    assert "No space left" in told.err
    assert Path("/dev/full").is_char_device()


def test_output_to_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    found: list[str] = []
    reader = threading.Thread(target=lambda: found.append(pipe.read_text()), daemon=True)
    reader.start()
    assert code_of("solve", EXAMPLES / "paper-4-items.json", "-q", "-o", pipe) == 0
    reader.join()
    assert json.loads(found[0])["schema"] == "qrobot.plan/1"


def test_progress_is_plain_without_a_terminal_and_absent_when_quiet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("QROBOT_HELPERS", "0")
    words = ("solve", EXAMPLES / "small-warehouse.json", "-b", "batching")
    process = start(*words, "-t", "3600")
    told = await_text(process.stderr, "batching: distance")
    process.send_signal(signal.SIGINT)
    told += process.communicate()[1]
    assert "\r" not in told
    assert "\x1b" not in told
    _, told = start(*words, "-t", "2.5", "--quiet").communicate()
    assert told == ""


def test_version_and_help() -> None:
    assert code_of("--version") == 0
    assert code_of("--help") == 0
    assert code_of("no-such-command") == 2
