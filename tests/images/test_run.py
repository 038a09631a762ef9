"""What users do with `docker run`, on a real engine."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from images.engine import BUILT, docker
from processes import until

from qrobot.plan import check, read_plan
from qrobot.problem.formats import read

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples/small-warehouse.json"
LOCKED = ("--network", "none", "--read-only", "--tmpfs", "/tmp", "--cap-drop", "ALL",
          "--security-opt", "no-new-privileges")  # fmt: skip
STRANGER = 4711


@pytest.fixture
def as_root(image: Callable[[str], str], tmp_path: Path) -> Callable[[str], None]:
    """Do something in a folder that only root may, whoever runs the tests."""

    def do(script: str) -> None:
        done = docker("run", "--rm", "--user", "0", "--entrypoint", "sh", "-v", f"{tmp_path}:/x",
                      image("solver"), "-c", f"cd /x && {script}")  # fmt: skip
        assert done.returncode == 0, done.stderr

    return do


@pytest.fixture
def folder(tmp_path: Path, as_root: Callable[[str], None]) -> Iterator[Path]:
    """A folder of another owner, who lets others read."""
    place = tmp_path / "orders"
    place.mkdir()
    shutil.copy(EXAMPLE, place / "orders.json")
    tmp_path.chmod(0o755)
    as_root(f"chmod 755 orders && chown -R {STRANGER}:{STRANGER} orders")
    yield place
    as_root(f"chown -R {os.getuid()} orders && chmod -R u+rwX orders")


def test_the_example_is_planned_with_everything_locked_down(run: Any, tmp_path: Path) -> None:
    done = run("solver", "solve", "example", "--json", "--max-work", "50", options=LOCKED)
    assert done.returncode == 0, done.stderr
    file = tmp_path / "plan.json"
    file.write_text(done.stdout)
    assert check(read_plan(file), read(EXAMPLE)).ok


def test_no_container_waits_for_a_compiler(run: Any) -> None:
    """The machine code of the searches is in the image; a locked container copies it to /tmp."""
    done = run("solver", "compile", "--json", options=LOCKED)
    assert done.returncode == 0, done.stderr
    script = (
        "from qrobot.backends.classical.compilation import compile_searches\n"
        "import sys\n"
        "compile_searches()\n"
        "modules = [m for name, m in sys.modules.items() if name.startswith('qrobot.')]\n"
        "stats = [getattr(k, 'stats', None) for m in modules for k in vars(m).values()]\n"
        "stats = [one for one in stats if getattr(one, 'cache_path', None)]\n"
        "print(sum(sum(one.cache_hits.values()) for one in stats))\n"
        "print(sum(sum(one.cache_misses.values()) for one in stats))\n"
    )
    done = run("solver", "python3", "-c", script, options=LOCKED)
    hits, misses = map(int, done.stdout.split())
    assert hits >= 8
    assert misses == 0
    done = run("solver", "solve", "example", "-t", "4", "--json", options=LOCKED)
    assert "qrobot compile" not in done.stderr + done.stdout


def test_a_mounted_folder_of_another_owner_is_read(run: Any, folder: Path) -> None:
    done = run("solver", "solve", "/data/orders.json", "-q", "--max-work", "50",
               options=(*LOCKED, "-v", f"{folder}:/data"))  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_where_it_may_not_write_it_says_how_to(run: Any, folder: Path) -> None:
    arguments = ("solve", "/data/orders.json", "-q", "--max-work", "50", "-o", "/data/plan.json")
    mount = (*LOCKED, "-v", f"{folder}:/data")
    done = run("solver", *arguments, options=mount)
    assert done.returncode == 2
    assert "docker run --user $(id -u):$(id -g)" in done.stderr
    done = run("solver", *arguments, options=(*mount, "--user", f"{STRANGER}:{STRANGER}"))
    assert done.returncode == 0, done.stderr
    plan = folder / "plan.json"
    assert plan.stat().st_uid == STRANGER
    assert check(read_plan(plan), read(folder / "orders.json")).ok


def test_a_file_that_only_its_owner_may_read(
    run: Any, folder: Path, as_root: Callable[[str], None]
) -> None:
    as_root("chmod 600 orders/orders.json")
    done = run("solver", "solve", "/data/orders.json", options=(*LOCKED, "-v", f"{folder}:/data"))
    assert done.returncode == 2
    assert "/data/orders.json" in done.stderr
    assert "docker run --user $(id -u):$(id -g)" in done.stderr


@pytest.mark.parametrize("backend", ["exact", "pyvrp", "batching", "neal", "statevector"])
def test_solver_holds_its_backends(run: Any, backend: str) -> None:
    done = run("solver", "solve", "example:three-items", "-b", backend, "--max-work", "200",
               "--json", options=LOCKED)  # fmt: skip
    assert done.returncode == 0, done.stderr
    one_way = read(ROOT / "examples/three-items.json")
    assert json.loads(done.stdout)["distance"] == pytest.approx(shortest(one_way))


def shortest(instance: Any) -> float:
    """The shortest round of three items, by trying all."""
    from itertools import permutations

    d = instance.place_distances
    return float(min(d[0, a] + d[a, b] + d[b, c] + d[c, 0] for a, b, c in permutations((1, 2, 3))))


def test_edge_solves_on_every_stack(run: Any) -> None:
    for backend in ("qiskit-vqe", "pennylane-vqe", "braket-vqe"):
        done = run("edge", "solve", "example:three-items", "-b", backend, "-O", "evaluations=8",
                   "--encoding", "compact", "--reads", "500", "-t", "150", "--json",
                   options=LOCKED)  # fmt: skip
        assert done.returncode == 0, (backend, done.stderr)
        assert json.loads(done.stdout)["result"]["sampler"]["reads"] >= 500


def test_every_stack_of_edge_computes(run: Any) -> None:
    done = run("edge", "health", "--profile", "edge", "--jobs", "2", "--json", options=LOCKED)
    checks = json.loads(done.stdout)["checks"]
    assert {check["name"]: check["status"] for check in checks if check["status"] != "pass"} == {}
    assert done.returncode == 0, done.stderr
    assert len(checks) >= 29


def test_a_file_in_the_mounted_folder_is_data_and_no_module(run: Any, tmp_path: Path) -> None:
    """Searches of three seconds and more start helpers; they begin in /data too."""
    shutil.copy(EXAMPLE, tmp_path / "orders.json")
    planted = "open('/data/run', 'a').write(__name__); raise SystemExit(3)\n"
    for name in ("numpy", "dimod", "psutil", "json"):
        (tmp_path / f"{name}.py").write_text(planted)
    tmp_path.chmod(0o777)
    for arguments in (("solve", "/data/orders.json", "-t", "4", "-q"), ("health", "--quick")):
        done = run("solver", *arguments, options=("-v", f"{tmp_path}:/data"))
        assert done.returncode == 0, done.stderr
    assert not (tmp_path / "run").exists()


def test_it_does_not_run_as_root(run: Any) -> None:
    for target in BUILT:
        done = run(target, "sh", "-c", "id -u; id -g; touch /usr/x 2>&1; touch /data/x 2>&1")
        lines = done.stdout.splitlines()
        assert lines[:2] == ["10001", "10001"]
        assert sum("ermission denied" in line for line in lines) == 2, done.stdout


def test_it_stops_at_once_when_asked(image: Callable[[str], str], tmp_path: Path) -> None:
    """tini hands the signal on, and the best plan so far is kept."""
    tmp_path.chmod(0o777)
    started = docker("run", "-d", "-v", f"{tmp_path}:/data", image("solver"), "solve", "example",
                     "-t", "3600", "-o", "/data/plan.json")  # fmt: skip
    name = started.stdout.strip()
    try:
        until(lambda: "distance" in docker("logs", name).stderr, "there is no plan")
        stopped = docker("stop", "-t", "600", name)
        assert stopped.returncode == 0
        code = docker("inspect", "-f", "{{.State.ExitCode}}", name).stdout.strip()
        assert code != "137", "it had to be killed"
    finally:
        docker("rm", "-f", name)
    assert check(read_plan(tmp_path / "plan.json"), read(EXAMPLE)).ok


def health_of(name: str) -> str:
    def status() -> str:
        return docker("inspect", "-f", "{{.State.Health.Status}}", name).stdout.strip()

    until(lambda: status() in ("healthy", "unhealthy"), "its health is not told")
    return status()


@pytest.mark.parametrize("broken", [False, True])
def test_the_health_check_tells_a_broken_wheel(
    image: Callable[[str], str], broken: bool, tmp_path: Path
) -> None:
    site = docker("run", "--rm", image("solver"), "python3", "-c",
                  "import dimod; print(dimod.__path__[0])").stdout.strip()  # fmt: skip
    (tmp_path / "__init__.py").write_text("raise ImportError('a broken wheel')\n")
    tmp_path.chmod(0o755)
    mount = ("-v", f"{tmp_path}:{site}:ro") if broken else ()
    name = docker("run", "-d", "--health-interval", "1s", "--health-start-period", "0s",
                  "--health-retries", "1", *mount, "--entrypoint", "sleep", image("solver"),
                  "3600").stdout.strip()  # fmt: skip
    try:
        assert health_of(name) == ("unhealthy" if broken else "healthy")
    finally:
        docker("rm", "-f", name)
