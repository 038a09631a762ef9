"""Formats are known by the suffix of their files; what one does not know is refused."""

from __future__ import annotations

import re
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from click.testing import CliRunner

import qrobot
from qrobot import _formats
from qrobot.cli.main import COMMANDS, cli
from qrobot.errors import InputError
from qrobot.problem import Instance
from qrobot.problem.formats import Format, ReadOptions, register, registry, suffixes
from qrobot.problem.warehouse import Warehouse
from qrobot.study.bench import find_instances

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(autouse=True)
def _own_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_registered", {})


def read_copy(path: Path, options: ReadOptions) -> Instance:
    """Read a native file by its name in another file."""
    assert options.layout is None
    return qrobot.read(path.read_text())


COPY = Format("the name of another file", ".copy", read=read_copy)


@pytest.mark.parametrize("suffix", [*_formats.BUILTIN])
def test_ours_are_registered_under_their_own_suffix(suffix: str) -> None:
    found = registry.formats_of(suffix)
    assert found
    for format_ in found:
        assert format_.suffix == suffix
        assert format_.options <= {*_formats.TABLE, "rounding"}
        assert len(found) == 1 or format_.recognise is not None


def test_a_registered_format_is_read_found_and_named(tmp_path: Path) -> None:
    path = tmp_path / "a.COPY"
    path.write_text(str(EXAMPLES / "paper-7-items.json"))
    with pytest.raises(InputError, match=r"give a \.json, \.csv, \.xlsx, \.vrp, \.txt or \.ord fi"):
        qrobot.read(path)
    register(COPY)
    assert suffixes() == [".json", ".csv", ".xlsx", ".vrp", ".txt", ".ord", ".copy"]
    assert qrobot.read(path, robots=2).items == qrobot.read(EXAMPLES / "paper-7-items.json").items
    assert find_instances(tmp_path) == [path]
    with pytest.raises(InputError, match="a layout belongs to CSV orders"):
        qrobot.read(path, layout="layout.json")
    (tmp_path / "a.doc").touch()
    with pytest.raises(InputError, match=r"\.vrp, \.txt, \.ord or \.copy file"):
        qrobot.read(tmp_path / "a.doc")


def test_the_help_names_the_formats_that_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    theirs = EntryPoint("xyz", "house:FORMAT", _formats.GROUP)
    monkeypatch.setattr(_formats, "plugins", lambda: {".xyz": theirs})
    helps = {}
    for name in COMMANDS:
        words = CliRunner().invoke(cli, [name, "--help"]).output.split()
        helps[name] = " ".join(words)
    assert ".vrp (CVRPLIB and QOBLIB)" in helps["solve"]
    assert ".xyz (of house:FORMAT)" in helps["solve"]
    assert "(.json, .csv, .xlsx, .vrp, .txt, .ord, .xyz)" in helps["bench"]
    readers = ("solve", "next", "check", "picklist", "schedule")
    assert all("robots of .csv, .xlsx, .ord orders" in helps[name] for name in readers)
    options = "|".join([*_formats.TABLE, "rounding"])
    places = rf"\{{(formats|suffixes|{options})\}}"
    assert not any(re.search(places, text) for text in helps.values())


@pytest.mark.parametrize("name", ["a.csv", "a.VRP", "a.copy"])
def test_a_file_that_is_only_read_is_not_written(name: str, tmp_path: Path) -> None:
    register(COPY)
    with pytest.raises(InputError, match=r"are only read; give a \.json file"):
        qrobot.write(EXAMPLES / "paper-7-items.json", tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ["copy", ".", "", ".CSV", ".csv", ".json"])
def test_a_suffix_that_cannot_be_one_is_refused(suffix: str) -> None:
    with pytest.raises(InputError, match=r"suffix: "):
        register(Format("x", suffix, read=read_copy))
    assert suffixes() == [".json", ".csv", ".xlsx", ".vrp", ".txt", ".ord"]


@pytest.mark.parametrize("name", ["small-warehouse.json", "paper-7-items.json"])
def test_every_kind_of_warehouse_answers_what_is_asked(name: str) -> None:
    instance = qrobot.read(EXAMPLES / name)
    house: Warehouse = instance.warehouse
    asked = {n for n in dir(Warehouse) if not n.startswith("_")}
    assert asked <= set(dir(house))
    assert house.distance_matrix(instance.places).shape == (len(instance.places) + 1,) * 2
