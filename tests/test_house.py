"""Rules of the house: light imports, doors that list their exports, arrows that go down."""

from __future__ import annotations

import ast
import importlib
import importlib.metadata
import re
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path
from typing import TypeGuard

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import qrobot
from qrobot import errors

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "qrobot"

HEAVY = {
    "amazon", "braket", "dwave", "jinja2", "matplotlib", "numba", "ortools", "pandas", "pennylane",
    "pyvrp", "qiskit", "scipy", "tensorflow",
}  # fmt: skip


def rooms() -> dict[str, set[str]]:
    """Return for each room of docs/architecture.md, from the bottom up, what it may import."""
    page = (ROOT / "docs/architecture.md").read_text()
    rows = re.findall(r"^\| `qrobot/(\w+)/` \|.*\| ([^|]+) \|$", page, re.MULTILINE)
    return {
        room: set() if allowed.startswith("nothing") else set(allowed.split(", "))
        for room, allowed in rows
    }


MAY_IMPORT = rooms()
FLOORS = list(MAY_IMPORT)
LONGEST = 400


def loaded_by(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return {name.split(".")[0] for name in done.stdout.split()}


def test_importing_qrobot_loads_nothing_heavy() -> None:
    assert not loaded_by("import qrobot") & (HEAVY | {"numpy", "pydantic", "dimod", "rich"})


def test_help_loads_nothing_heavy() -> None:
    statement = "from qrobot.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    ours = {"numpy", "pydantic", "dimod", "logging", "secrets", "json"}
    assert not loaded_by(f"exec({statement!r})") & (HEAVY | ours)


def test_exact_plans_need_nothing_heavy() -> None:
    statement = (
        "import qrobot; qrobot.solve(qrobot.read('examples/paper-7-items.json'), deadline=5)"
    )
    assert not loaded_by(statement) & (HEAVY | {"dimod"})


def test_the_door_lists_what_it_hands_out() -> None:
    assert sorted(qrobot.__all__) == qrobot.__all__
    for name in qrobot.__all__:
        assert getattr(qrobot, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = qrobot.nonsense
    assert set(dir(qrobot)) == set(qrobot.__all__)


@pytest.mark.parametrize("room", FLOORS)
def test_every_room_lists_its_exports(room: str) -> None:
    door = importlib.import_module(f"qrobot.{room}")
    assert door.__doc__
    for name in door.__all__:
        assert hasattr(door, name)


def test_a_module_lists_what_others_take_from_it() -> None:
    """But for health checks, each of which is a file of one form."""
    lists, taken = {}, []
    for path in PACKAGE.rglob("*.py"):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        tree = ast.parse(path.read_text())
        lists[name] = next((ast.literal_eval(n.value) for n in tree.body if is_list(n)), [])
        taken += [(name, n) for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
    for name, node in taken:
        for alias in node.names if node.module in lists else ():
            if ".checks." in str(node.module) or f"{node.module}.{alias.name}" in lists:
                continue
            known = alias.name in lists[node.module] or alias.name.startswith("__")
            assert known, f"{name} takes {alias.name}, which {node.module} does not list"


def is_list(node: ast.stmt) -> TypeGuard[ast.Assign]:
    """Return whether a statement is the list of a module's names."""
    return (
        isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and node.targets[0].id == "__all__"
    )


@pytest.mark.parametrize("room", FLOORS)
def test_arrows_go_down_only(room: str) -> None:
    for path in (PACKAGE / room).rglob("*.py"):
        for module in imported_at_run_time(ast.parse(path.read_text())):
            parts = module.split(".")
            if parts[0] == "qrobot" and len(parts) > 1 and parts[1] in FLOORS:
                assert parts[1] == room or parts[1] in MAY_IMPORT[room], f"{path}: {module}"


def test_the_table_names_every_room_once_and_from_the_bottom_up() -> None:
    folders = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    assert set(FLOORS) == folders
    for room, allowed in MAY_IMPORT.items():
        assert allowed <= set(FLOORS[: FLOORS.index(room)]), room


def test_no_files_import_each_other_in_a_circle() -> None:
    files = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): path
        for path in PACKAGE.rglob("*.py")
        if path.name != "__init__.py"  # a door imports its room, which imports by the door's name
    }
    graph = {
        name: {m for m in imported_on_top(ast.parse(path.read_text())) if m in files}
        for name, path in files.items()
    }
    TopologicalSorter(graph).prepare()  # raises CycleError, with the cycle


SOURCES = ("qrobot", "ansible", "benchmarks", "docker", "healthchecks", "locks", "tests")


def test_modules_are_short() -> None:
    for path in (path for folder in SOURCES for path in (ROOT / folder).rglob("*.py")):
        assert path.read_text().count("\n") <= LONGEST, path


def test_no_program_changes_where_modules_are_found() -> None:
    """Neither a module, nor a program without a suffix, nor one in a text that is run."""
    change = re.compile(rb"\bsys\.path(\[|\.(insert|append|extend)| \+?= )")
    files = (
        path for folder in (*SOURCES, "docs", "examples") for path in (ROOT / folder).rglob("*")
    )
    for path in files:
        if path.is_file() and path.suffix != ".pyc":
            assert not change.search(path.read_bytes()), path


ONCE = {
    r"\bos\.fork\(|\bprctl\b|\bgetppid\b|\bkillpg\b|\bsignal\.signal\(": "_processes.py",
    r"\bru_maxrss\b|\bVmHWM\b|\"/?proc/cpuinfo\"|sys/fs/cgroup|sched_getaffinity": "_machine.py",
    r"\bmetadata\.(requires|version)\(|\bfind_spec\(": "_extras.py",
    r"pip install 'qrobot\[\{": "errors.py",
    r"\bos\.(replace|rename|fsync)\(": "_files.py",
    r"\.rjust\(": "_text.py",
    r"\bjinja2\b": "kit.py",
    r"\bcsv\.(DictWriter|writer)\(": "_csv.py",
}
"""Mechanisms, and the one file of the package that has each."""


@pytest.mark.parametrize("pattern", ONCE)
def test_a_mechanism_stands_once(pattern: str) -> None:
    using = {path.name for path in PACKAGE.rglob("*.py") if re.search(pattern, path.read_text())}
    assert using == {ONCE[pattern]}


def imported_on_top(tree: ast.Module) -> set[str]:
    """Return the modules that a module imports when it is imported itself."""
    found: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def imported_at_run_time(tree: ast.AST) -> list[str]:
    found = []
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            found.append(node.module)
        elif isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        found += imported_at_run_time(node)
    return found


def test_the_tree_of_errors_is_as_documented() -> None:
    text = errors.__doc__ or ""
    for name in set(errors.__all__) - {"INSTALL"}:
        error = getattr(errors, name)
        assert name in text
        assert issubclass(error, errors.QRobotError)
    assert errors.InputError("x").exit_code == 2
    assert errors.InfeasibleError("x").exit_code == 1
    assert errors.MissingExtraError("x", "y").exit_code == 3
    assert issubclass(errors.RemoteError, errors.BackendError)


def test_no_registry_and_no_secret_in_locks() -> None:
    for path in (ROOT / "locks").glob("*.txt"):
        assert "://" not in path.read_text(), path


@pytest.mark.parametrize("lock", sorted((ROOT / "locks").glob("*.txt")), ids=lambda path: path.stem)
def test_a_lock_holds_what_its_packages_require(lock: Path) -> None:
    """With hashes required, pip refuses a package whose requirement is not in the file."""
    locked = {
        canonicalize_name(n) for n in re.findall(r"^([\w.-]+)==", lock.read_text(), re.MULTILINE)
    }
    for name in locked:
        try:
            requirements = importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:
            continue  # another profile's, so its metadata is not at hand
        for requirement in map(Requirement, requirements):
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                assert canonicalize_name(requirement.name) in locked, f"{name} needs {requirement}"
