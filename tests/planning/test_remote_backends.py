"""Remote backends in `solve`: cost, fallback, timing, and answers that arrive later."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from oracles import least_distance, paper_shaped
from processes import HANG, with_our_modules

import qrobot
from qrobot.backends import registry
from qrobot.cli import main
from qrobot.jobs import JobStore
from qrobot.models import Penalties
from qrobot.planning import collect, estimate, submit

NAME = "file-service"


@pytest.fixture(autouse=True)
def service(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setitem(registry.BUILTIN, NAME, ("jobs.file_sampler", "FileSampler", "numpy"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("FILE_SERVICE", str(tmp_path / "service"))
    return tmp_path


@pytest.fixture
def instance() -> qrobot.Instance:
    return paper_shaped(3, 1, 4)  # compact: nine variables, which the service tries all


def jobs() -> list:
    with JobStore() as store:
        return store.list()


def test_a_plan_says_where_the_time_of_the_job_went(instance: qrobot.Instance) -> None:
    result = qrobot.solve(instance, backend=NAME, encoding="compact")
    assert result.cost == pytest.approx(least_distance(instance)[0])
    assert result.answered_by == NAME
    timing = result.timing
    assert min(timing.submit, timing.run, timing.return_, timing.build) > 0
    parts = (timing.submit, timing.latency, timing.queue, timing.run, timing.return_)
    job = result.sampler.details["remote"]["timing"]
    assert sum(parts) == pytest.approx(sum(job.values()))
    assert sum(parts) < timing.total
    assert result.sampler.details["remote"]["job"] == jobs()[0].id


def test_without_credentials_the_fallback_answers_and_says_so(
    instance: qrobot.Instance, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FILE_SERVICE_REFUSES", "1")
    with pytest.raises(qrobot.CredentialsError, match="refused the token"):
        qrobot.solve(instance, backend=NAME, encoding="compact")
    result = qrobot.solve(instance, backend=NAME, encoding="compact", fallback="neal", num_reads=20)
    assert (result.backend, result.answered_by) == (NAME, "neal")
    assert result.sampler.backend == "neal"
    assert result.sampler.reads == 20
    assert any("file-service failed, neal answered instead" in note for note in result.notes)
    assert result.to_dict()["result"]["answered_by"] == "neal"
    other = qrobot.solve(instance, backend=NAME, fallback="exact", encoding="compact")
    assert other.is_optimal


def test_a_missing_extra_falls_back_too(
    instance: qrobot.Instance, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(registry.BUILTIN, "moon", ("moon.base", "Moon", "moon"))
    result = qrobot.solve(instance, backend="moon", fallback="auto")
    assert result.answered_by == "auto"
    assert "install it with" in result.notes[-1]


def test_a_fallback_is_local_and_both_failures_are_told(
    instance: qrobot.Instance, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(qrobot.InputError, match="fallback: backend file-service is remote"):
        qrobot.solve(instance, backend="neal", fallback=NAME)
    monkeypatch.setitem(registry.BUILTIN, "moon", ("moon.base", "Moon", "moon"))
    monkeypatch.setattr(
        "qrobot.backends.annealing.samplers.NealSampler.sample",
        lambda *_, **__: 1 / 0,
        raising=True,
    )
    with pytest.raises(qrobot.BackendError, match=r"moon failed .* and so did the fallback neal"):
        qrobot.solve(instance, backend="moon", fallback="neal")


def test_infeasible_is_infeasible_with_any_backend(monkeypatch: pytest.MonkeyPatch) -> None:
    light = (replace(paper_shaped(3, 1, 4).robots[0], capacity=Fraction(1, 1000)),)
    heavy = replace(paper_shaped(3, 1, 4), robots=light)
    with pytest.raises(qrobot.InfeasibleError):
        qrobot.solve(heavy, backend=NAME, fallback="auto")
    assert not jobs()


def test_what_costs_too_much_is_not_submitted(instance: qrobot.Instance) -> None:
    assert estimate(instance, NAME, encoding="compact").usd == 0.5
    assert estimate(instance, "neal").usd == 0
    assert estimate(instance, "auto").usd == 0
    with pytest.raises(qrobot.BackendError, match="nothing was submitted"):
        qrobot.solve(instance, backend=NAME, encoding="compact", max_cost=0.1)
    assert not jobs()
    qrobot.solve(instance, backend=NAME, encoding="compact", max_cost=0.6)
    assert qrobot.solve(instance, backend="neal", max_cost=0.0).cost  # nothing is billed here
    with pytest.raises(qrobot.InputError, match="max_cost"):
        qrobot.solve(instance, backend="neal", max_cost=-1.0)


def test_a_job_becomes_a_plan_later(instance: qrobot.Instance) -> None:
    job = submit(instance, NAME, encoding="compact")
    with JobStore() as store:
        result = collect(job["id"], store)
    assert result.cost == pytest.approx(least_distance(instance)[0])
    assert qrobot.check(result.plan, instance).ok
    with pytest.raises(qrobot.InputError, match="runs on this machine"):
        submit(instance, "neal")


def test_the_commands_do_the_same_in_processes_of_their_own(
    instance: qrobot.Instance, service: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, plan = service / "question.json", service / "plan.json"
    qrobot.write(instance, file)
    asked = ["solve", str(file), "-b", NAME, "--encoding", "compact"]

    def run(*words: str) -> str:
        with pytest.raises(SystemExit) as ended:
            main(list(words))
        assert ended.value.code == 0, capsys.readouterr().err
        return capsys.readouterr().out

    assert "would cost 0.5 USD" in run(*asked, "--dry-run")
    assert not jobs()
    job = json.loads(run(*asked, "--no-wait", "--json"))["id"]
    # Another process makes the plan: all that it needs was kept.
    script = (
        "from qrobot.backends import registry\n"
        f"registry.BUILTIN[{NAME!r}] = ('jobs.file_sampler', 'FileSampler', 'numpy')\n"
        "from qrobot.cli import main\n"
        f"main(['jobs', 'fetch', {job!r}, '--plan', {str(plan)!r}])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True, text=True, check=False, env=with_our_modules(),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "written:" in done.stdout
    assert run("check", str(plan), str(file))
    with pytest.raises(SystemExit) as ended:
        main([*asked, "--max-cost", "0.2", "--fallback", "exact", "--json"])
    assert ended.value.code == 0
    assert json.loads(capsys.readouterr().out)["result"]["answered_by"] == "exact"


def test_any_option_of_a_sampler_can_be_set(
    instance: qrobot.Instance, service: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = service / "question.json"
    qrobot.write(instance, file)
    for words, code, told in (
        (("-O", "num_reads=7"), 0, ""),
        (("-O", "colour=red"), 2, "takes no option colour"),
        (("-O", "colour"), 2, "name=value"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["solve", str(file), "-b", "neal", "--json", *words])
        printed = capsys.readouterr()
        assert ended.value.code == code
        assert told in printed.err
        if code == 0:
            assert json.loads(printed.out)["result"]["sampler"]["reads"] == 7


def test_the_random_control_is_what_a_count_of_all_assignments_says() -> None:
    instance = paper_shaped(3, 1, 4)
    result = qrobot.solve(
        instance, backend="neal", encoding="compact", num_reads=4000, control=True, deadline=HANG
    )
    report = result.sampler
    assert result.is_optimal
    # Nine bits: six of the 512 assignments are tours, and both ways round the best are optimal.
    assert report.random_feasible_fraction == pytest.approx(6 / 512, abs=0.006)
    assert report.random_optimal_fraction == pytest.approx(2 / 512, abs=0.004)
    assert report.random_best == pytest.approx(least_distance(instance)[0])
    assert report.optimal_fraction > 0.3
    assert report.feasible_fraction > 0.9


def test_rounds_of_a_remote_backend_share_one_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    # The service answers with the three lowest energies: an overload, until it costs enough.
    instance = paper_shaped(3, 2, 0)
    with pytest.raises(qrobot.InputError, match="rounds"):
        qrobot.solve(instance, backend=NAME, rounds=0)
    one = qrobot.solve(instance, backend=NAME)
    assert one.sampler.rounds == 1
    assert one.sampler.best is None
    assert len(jobs()) == 1
    two = qrobot.solve(instance, backend=NAME, rounds=8, max_cost=1.1)
    assert len(jobs()) == 3  # two at half a dollar each, then no third
    assert two.sampler.rounds == 2
    assert any("more than the limit of 0.1 USD" in note for note in two.notes)
    more = qrobot.solve(instance, backend=NAME, rounds=8)
    assert more.sampler.best == pytest.approx(least_distance(instance)[0])
    assert 1 < more.sampler.rounds <= 8


def test_a_round_that_fails_costs_no_reads_of_the_rounds_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    instance = paper_shaped(3, 2, 0)
    result = qrobot.solve(instance, backend=NAME, rounds=8, max_cost=0.9)
    assert result.sampler.rounds == 1  # the second would have cost too much
    assert result.sampler.best is None
    assert any("round 2 of file-service failed" in note for note in result.notes)
    assert len(jobs()) == 1


def test_a_job_for_later_keeps_its_objective(
    instance: qrobot.Instance, service: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    items = tuple(replace(item, pick_seconds=7.0) for item in instance.items)
    robots = tuple(replace(robot, speed=0.5) for robot in instance.robots)
    slow = replace(instance, items=items, robots=robots)
    qrobot.write(slow, service / "question.json")
    with pytest.raises(SystemExit) as ended:
        main(["solve", str(service / "question.json"), "-b", NAME, "--encoding", "compact",
              "--no-wait", "--objective", "time"])  # fmt: skip
    assert ended.value.code == 0
    assert "makes a plan of it" in capsys.readouterr().out
    with JobStore() as store:
        result = collect(jobs()[0].id, store)
    assert result.objective == "time"
    assert result.cost == pytest.approx(least_distance(instance)[0] / 0.5 + 3 * 7)
    assert qrobot.check(result.plan, slow).ok


def test_a_job_for_later_is_refused_an_objective_that_its_sampler_cannot_optimise(
    instance: qrobot.Instance,
) -> None:
    fast = replace(instance.robots[0], id="fast", speed=9.0)
    unlike = replace(instance, robots=(*instance.robots, fast))
    with pytest.raises(qrobot.InputError, match="cannot optimise time with unlike robots"):
        submit(unlike, NAME, objective="time")
    assert not jobs()


def test_waiting_is_no_option_of_solve(instance: qrobot.Instance) -> None:
    for name, advice in (("wait", "--no-wait"), ("dry_run", "--dry-run")):
        with pytest.raises(qrobot.InputError, match=advice):
            qrobot.solve(instance, backend=NAME, **{name: False})
    assert not jobs()


def test_a_planner_that_falls_back_has_no_control(
    instance: qrobot.Instance, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FILE_SERVICE_REFUSES", "1")
    result = qrobot.solve(instance, backend=NAME, control=True, fallback="auto")
    assert result.answered_by == "auto"
    assert "refused the token" in result.notes[-1]


def test_names_and_weights_survive_the_job_store(instance: qrobot.Instance) -> None:
    """An item may be called like a secret, and weights may be an object."""
    items = (replace(instance.items[0], id="token 2024box"), *instance.items[1:])
    orders = tuple(replace(o, items=(i.id,)) for o, i in zip(instance.orders, items, strict=True))
    asked = replace(instance, items=items, orders=orders)
    weights = Penalties.measured(asked)
    job = submit(asked, NAME, encoding="compact", penalties=weights)
    with JobStore() as store:
        result = collect(job["id"], store)
    assert qrobot.check(result.plan, asked).ok


def test_an_estimate_is_of_the_job_that_would_be_sent(
    instance: qrobot.Instance, monkeypatch: pytest.MonkeyPatch
) -> None:
    from jobs.file_sampler import FileSampler

    asked: list[dict] = []
    real = FileSampler.estimate
    monkeypatch.setattr(FileSampler, "picking_defaults", lambda *_, **__: {"num_reads": 77})
    monkeypatch.setattr(
        FileSampler, "estimate", lambda self, bqm, **p: asked.append(p) or real(self, bqm, **p)
    )
    estimate(instance, NAME, encoding="compact")
    qrobot.solve(instance, backend=NAME, encoding="compact")
    assert asked == [{"num_reads": 77}] * 2
    estimate(instance, NAME, encoding="compact", max_work=5)
    assert asked[-1] == {"num_reads": 5}


def test_nothing_to_collect_is_no_job(instance: qrobot.Instance) -> None:
    nothing = replace(instance, items=(), orders=())
    assert estimate(nothing, NAME).usd == 0
    with pytest.raises(qrobot.InputError, match="nothing to collect"):
        submit(nothing, NAME)
