"""Exports of a warehouse management system: columns of any name, labels, an article master."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from exports import ARTICLES, COLUMNS, LAYOUT, LOCATIONS, MAPPING, ORDERS, read, refusal, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.cli.main import cli
from qrobot.errors import InputError
from qrobot.problem import Order, Point, Slot
from qrobot.report import pick_lists
from qrobot.study.bench import find_instances


def test_an_export_is_read_with_its_masters(tmp_path: Path) -> None:
    one = read(tmp_path)
    assert [
        (i.id, i.article, i.place, i.label, i.level, i.quantity, i.weight, i.volume, i.category)
        for i in one.items
    ] == [
        ("A1/10-1", "10-1", Slot(0, 2, 1), "A01-03-2", 2, 2, 5, Fraction(3, 2), "tools"),
        ("10-2", "", Slot(1, 0, 0, "right"), "B02-01-1", 1, 1, Fraction(5, 4), 3, ""),
        ("A2/10-1", "10-1", Slot(0, 2, 1), "A01-03-2", 2, 3, Fraction(15, 2), Fraction(9, 4),
         "tools"),
    ]  # fmt: skip
    assert one.orders == (Order("A1", ("A1/10-1", "10-2")), Order("A2", ("A2/10-1",)))
    assert one.notes == ()


def test_labels_come_back_in_plans_and_pick_lists(tmp_path: Path) -> None:
    path, plan = write(tmp_path), tmp_path / "plan.json"
    words = ["--columns", MAPPING]
    done = CliRunner().invoke(cli, ["solve", str(path), *words, "-o", str(plan)])
    assert done.exit_code == 0, done.output
    assert "A1/10-1 (A01-03-2)" in done.output
    done = CliRunner().invoke(cli, ["check", str(plan), str(path), *words])
    assert done.exit_code == 0, done.output
    for form in ("csv", "json", "html", None):
        more = ["--format", form] if form else []
        done = CliRunner().invoke(cli, ["picklist", str(plan), str(path), *words, *more])
        assert done.exit_code == 0, done.output
        assert "A01-03-2" in done.output
        assert "B02-01-1" in done.output
        assert "aisle 0" not in done.output
    lists = pick_lists(plan, qrobot.read(path, columns=COLUMNS))
    known = {row.split(",")[0] for row in LOCATIONS.splitlines()}
    assert {pick.location for one in lists.lists for pick in one.picks} <= known


@pytest.mark.parametrize(
    "mapping",
    [
        [MAPPING],
        ["order=OrderNo", " article = sku ,place=bin", "quantity=QTY"],
        ["ORDER=OrderNo,article=SKU,label=BIN", "quantity=Qty,quantity=Pieces,weight=kg"],
    ],
)
def test_columns_on_the_command_line(tmp_path: Path, mapping: list[str]) -> None:
    articles = ARTICLES.replace("weight", "kg") if "kg" in str(mapping) else ARTICLES
    path = write(tmp_path, articles=articles)
    words = [word for text in mapping for word in ("--columns", text)]
    done = CliRunner().invoke(cli, ["solve", str(path), *words, "--json"])
    if "Pieces" in str(mapping):  # no file calls a column so
        assert isinstance(done.exception, InputError)
        assert "wave.csv: line 1: no column is called 'Pieces'" in str(done.exception)
        return
    assert done.exit_code == 0, done.output
    stops = {stop for trip in json.loads(done.stdout)["trips"] for stop in trip["stops"]}
    assert stops == {item.id for item in qrobot.read(path, columns=COLUMNS).items}


@pytest.mark.parametrize("text", ["order", "order=", "=OrderNo", "order=OrderNo,SKU"])
def test_a_mapping_that_maps_nothing(tmp_path: Path, text: str) -> None:
    done = CliRunner().invoke(cli, ["solve", str(write(tmp_path)), "--columns", text])
    assert "--columns: " in str(done.exception)
    assert "maps nothing; write it as order=OrderNo" in str(done.exception)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"order": "OrderNr"},
            "wave.csv: line 1: no column is called 'OrderNr' (which --columns calls order); "
            "did you mean 'OrderNo'?",
        ),
        (
            {"order": "Kunde"},
            "wave.csv: line 1: no column is called 'Kunde' (which --columns calls order); the "
            "header has OrderNo, SKU, BIN, Qty",
        ),
        ({"ordr": "OrderNo"}, "columns: 'ordr' is not a column that qRobot reads; did you mean 'o"),
        ({"item": "SKU"}, "columns: 'SKU' is to be both 'article' and 'item'; keep one of them"),
    ],
)
def test_a_mapping_that_names_no_column(tmp_path: Path, change: dict[str, str], said: str) -> None:
    found = refusal(tmp_path, COLUMNS | change)
    assert said in found
    assert found.startswith("wave.csv: ")


FAULTS = [
    # file, text, what to put there, what is said
    ("orders", "A01-03-2;3", "A01-03-9;3",
     "wave.csv: line 4, column BIN: 'A01-03-9' is not in {0}/wave.locations.csv; did you "
     "mean 'A01-03-"),
    ("orders", "A2;10-1", "A2;10-7",
     "wave.csv: line 4, column SKU: nothing says what '10-7' weighs; add it to the article master"),
    ("orders", ";B02-01-1;1", ";;1",
     "wave.csv: line 3, column BIN: '10-2' has no place, nor has its article; fill it in"),
    ("orders", "A2;10-1", ";10-1", "wave.csv: line 4, column OrderNo: is empty; fill it in"),
    ("orders", "Qty\nA1;10-1;A01-03-2;2", "Qty\nA1;10-1;A01-03-2;2,5",
     "wave.csv: line 2, column Qty: 2,5 is not a whole number from 1; correct it"),
    ("orders", "Qty", "Pieces", "wave.csv: line 1: no column is called 'Qty'"),
    ("locations", "A01-03-1", "A01-03-2",
     "wave.locations.csv: line 3, column label: 'A01-03-2' is in line 2 too; keep one"),
    ("locations", "1,0,0,right", "7,0,0,right",
     "wave.locations.csv: line 4, column aisle: aisle 7 is outside the layout; use 0 to 2, or"),
    ("locations", "0,1,2,left,2", "0,1,2,up,2",
     "wave.locations.csv: line 3, column side: 'up' is not a side; give left or right"),
    ("locations", "left,2", "left,2.5",
     "wave.locations.csv: line 3, column level: 2.5 is not a whole number from 0; correct it"),
    ("locations", "label,", "number,", "wave.locations.csv: line 1: column 'number' is not known"),
    ("locations", "level", "height", "wave.locations.csv: line 1: column 'height' is not known"),
    ("locations", "aisle,", "x,", "wave.locations.csv: line 1: the columns block, level, side, sl"),
    ("orders", ORDERS, "", "wave.csv: is empty; give a file with content"),
    ("locations", LOCATIONS, "", "{0}/wave.locations.csv: is empty; give a file with content"),
    ("articles", "10-2;1,25", "10-1;1,25",
     "wave.articles.csv: line 3, column weight: article '10-1' is in line 2 too, with '2,5' there"),
    ("articles", "10-2;1,25;3;", "10-1;2,5;0,75;tools",
     "wave.articles.csv: line 3, column article: article '10-1' is in line 2 too; keep one of the"),
    ("articles", "2,5", "-2,5",
     "wave.articles.csv: line 2, column weight: weight -2.5 of item '10-1' is negative; use zero"),
    ("articles", "2,5", "2kg", "wave.articles.csv: line 2, column weight: 2kg is not a finite num"),
    ("articles", "0,75", "-1", "wave.articles.csv: line 2, column volume: volume -1 of item '10-"),
    ("articles", "2,5", "", "wave.csv: line 2, column SKU: nothing says what '10-1' weighs"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "old", "new", "said"), FAULTS, ids=range(len(FAULTS)))
def test_every_fault_has_its_file_and_its_place(
    tmp_path: Path, kind: str, old: str, new: str, said: str
) -> None:
    text = {"orders": ORDERS, "locations": LOCATIONS, "articles": ARTICLES}[kind]
    assert old in text
    found = refusal(tmp_path, **{kind: text.replace(old, new, 1)})
    assert found.startswith(said.format(tmp_path).removeprefix(f"{tmp_path}/")), found


def test_without_a_location_table_a_label_means_nothing(tmp_path: Path) -> None:
    assert refusal(tmp_path, locations=None).startswith(
        "wave.csv: line 2, column BIN: 'A01-03-2' is a label, and there is no location table; add "
        "wave.locations.csv to the folder, or name one (--locations)"
    )


def test_an_article_with_two_weights(tmp_path: Path) -> None:
    """Two files that contradict each other are refused, two lines are told."""
    both = ORDERS.replace("Qty", "Qty;weight").replace(";2\n", ";2;2,5\n").replace(";1\n", ";1;\n")
    assert read(tmp_path, orders=both.replace(";3\n", ";3;2,50\n")) == read(tmp_path)
    assert refusal(tmp_path, orders=both.replace(";3\n", ";3;2,6\n")).startswith(
        f"wave.csv: line 4, column weight: 2,6 is not the 2,5 of {tmp_path}/wave.articles.csv, "
        "line 2, column weight; correct one of them, or leave this column out (--ignore-columns)"
    )
    alone = both.replace(";1;\n", ";1;1\n").replace(";3\n", ";3;2,6\n")
    one = read(tmp_path, orders=alone, articles=None)
    assert one.notes == ("1 article has several weights (10-1): each line counts its own",)
    assert [item.weight for item in one.items] == [5, 1, Fraction(39, 5)]


def test_an_article_in_two_places_is_told(tmp_path: Path) -> None:
    one = read(tmp_path, orders=ORDERS.replace("A01-03-2;3", "B02-01-1;3"))
    assert one.notes == (
        "1 article has several places (10-1): each line is collected from its own, no other is "
        "tried",
    )


def test_the_place_may_be_that_of_the_article(tmp_path: Path) -> None:
    orders = "\n".join(";".join(row.split(";")[:2] + row.split(";")[3:]) for row in ORDERS.split())
    articles = "article,weight,place\n10-1,2.5,A01-03-2\n10-2,1.25,B02-01-1\n"
    columns = {name: theirs for name, theirs in COLUMNS.items() if name != "place"}
    one = read(tmp_path, columns, orders=orders, articles=articles)
    assert [(i.place, i.label, i.level) for i in one.items] == [
        (i.place, i.label, i.level) for i in read(tmp_path).items
    ]


def test_numbers_may_have_labels_without_a_table(tmp_path: Path) -> None:
    rows = "order,item,weight,aisle,slot,level,label\nA,p,1,2,3,4,C 7\nA,q,1,0,0,,\n"
    one = qrobot.read(
        write(tmp_path, orders=rows.replace(",,", ",0,"), locations=None, articles=None)
    )
    assert [(i.place, i.label, i.level) for i in one.items] == [
        (Slot(2, 3), "C 7", 4), (Slot(0, 0), "", 0)
    ]  # fmt: skip


def test_labels_of_coordinates(tmp_path: Path) -> None:
    floor = LAYOUT | {"warehouse": {"kind": "floor"}}
    path = write(tmp_path, locations="label;x;y\nA01-03-2;1,5;-2\nB02-01-1;3;4\n")
    (tmp_path / "layout.json").write_text(json.dumps(floor))
    one = qrobot.read(path, columns=COLUMNS)
    assert [i.place for i in one.items] == [Point(1.5, -2), Point(3, 4), Point(1.5, -2)]


def test_lines_of_an_export_stay_apart(tmp_path: Path) -> None:
    one = read(tmp_path, orders=ORDERS + "A2;10-1;A01-03-2;1\nA2;10-2;B02-01-1;4\n")
    assert [i.id for i in one.items] == [
        "A1/10-1", "A1/10-2", "A2/10-1#1", "A2/10-1#2", "A2/10-2",
    ]  # fmt: skip
    assert [i.quantity for i in one.items] == [2, 1, 3, 1, 4]


def test_files_that_are_named_and_files_beside(tmp_path: Path) -> None:
    one = read(tmp_path)
    elsewhere = tmp_path / "other"
    elsewhere.mkdir()
    for kind in ("locations", "articles"):
        (tmp_path / f"wave.{kind}.csv").rename(elsewhere / f"{kind}.csv")
    given = {kind: elsewhere / f"{kind}.csv" for kind in ("locations", "articles")}
    assert qrobot.read(tmp_path / "wave.csv", columns=COLUMNS, **given) == one
    words = [word for kind, path in given.items() for word in (f"--{kind}", str(path))]
    words += ["--columns", MAPPING]
    done = CliRunner().invoke(cli, ["solve", str(tmp_path / "wave.csv"), *words, "--json"])
    assert done.exit_code == 0, done.output
    for kind, path in given.items():
        path.rename(tmp_path / f"{kind}.csv")
    assert qrobot.read(tmp_path / "wave.csv", columns=COLUMNS) == one
    assert find_instances(tmp_path) == [tmp_path / "wave.csv"]
    plan = tmp_path / "locations.csv"
    done = CliRunner().invoke(
        cli, ["solve", str(tmp_path / "wave.csv"), "--locations", str(plan), "-o", str(plan)]
    )
    assert "is an input" in str(done.exception)


def test_columns_that_are_not_ours(tmp_path: Path) -> None:
    orders = ORDERS.replace("Qty", "Qty;Kunde;Order").replace(";2\n", ";2;Ann;7\n")
    orders = orders.replace(";1\n", ";1;Bob;8\n").replace(";3\n", ";3;Cy;9\n")
    assert "column 'kunde' is not known; " in refusal(tmp_path, orders=orders)
    some = {"ignore_columns": ["Kunde"]}
    assert refusal(tmp_path, COLUMNS, some, orders=orders).startswith(
        "wave.csv: line 1: column 'order' is not the one that the mapping calls 'order'; give "
        "--ignore-columns order"
    )
    named = read(tmp_path, COLUMNS, {"ignore_columns": ["Kunde", "order"]}, orders=orders)
    assert named == read(tmp_path)
    every = read(tmp_path, COLUMNS, {"ignore_columns": ["*"]}, orders=orders)
    assert every == named
    assert every.notes == ("2 columns ignored: kunde, order",)
    assert "cannot be ignored: it is needed" in refusal(
        tmp_path, COLUMNS, {"ignore_columns": ["OrderNo"]}
    )
    twice = ORDERS.replace("Qty", "Qty;place").replace("2\n", "2;x\n")
    assert "is not the one that the mapping calls 'place'" in refusal(
        tmp_path, orders=twice.replace(";1\n", ";1;\n").replace(";3\n", ";3;\n")
    )
    assert "line 1: 'label' and 'place' are both 'place'; keep one" in refusal(
        tmp_path, locations=LOCATIONS.replace("side", "place")
    )


names = st.text("abcXYZäß 0-9_/", min_size=1, max_size=12).map(lambda s: " ".join(s.split()))
distinct = st.lists(
    names.filter(lambda name: name and name.lower() not in {"*", *ORDERS.lower().split(";")}),
    min_size=4, max_size=4, unique_by=lambda name: qrobot.problem.checks.canonical(name).lower(),
)  # fmt: skip


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(distinct, st.permutations(range(4)), st.sampled_from(",;\t"))
def test_columns_of_any_name_in_any_sequence(
    tmp_path: Path, called: list[str], sequence: Sequence[int], delimiter: str
) -> None:
    rows = [row.split(";") for row in ORDERS.split()]
    rows[0] = called
    text = "\n".join(delimiter.join(row[at] for at in sequence) for row in rows)
    columns = dict(zip(COLUMNS, called, strict=True))
    given = {"columns": columns, "ignore_columns": []}
    (tmp_path / "other").mkdir(exist_ok=True)
    assert qrobot.read(write(tmp_path / "other", orders=text), **given) == read(tmp_path)


def test_ten_thousand_lines_take_work_that_grows_with_the_lines(tmp_path: Path) -> None:
    """Counted, not timed: cells that are read, of so many lines and of four times as many."""
    from qrobot.problem.formats.cells import Line

    def work(lines: int) -> int:
        rows = [f"O{n // 4};S{n % 400};B{n % 300};{1 + n % 3}" for n in range(lines)]
        bins = [f"B{n},{n % 3},{n % 2},{n % 4},left,0" for n in range(300)]
        goods = [f"S{n};1,5;1;" for n in range(400)]
        seen = 0

        def text(self: Line, column: str, _real: Any = Line.text) -> str:
            nonlocal seen
            seen += 1
            return _real(self, column)

        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(Line, "text", text)
            one = qrobot.read(
                write(
                    tmp_path,
                    orders="\n".join([ORDERS.split(maxsplit=1)[0], *rows]),
                    locations="\n".join([LOCATIONS.split(maxsplit=1)[0], *bins]),
                    articles="\n".join([ARTICLES.split(maxsplit=1)[0], *goods]),
                ),
                columns=COLUMNS,
                pool=True,
            )
        assert one.size == lines
        return seen

    small, large = work(2_500), work(10_000)
    assert large <= 4 * small
