"""CSV in the shapes that spreadsheets of all countries give it."""

from __future__ import annotations

import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance, Order
from qrobot.problem.formats.cells import DecimalMarks
from qrobot.problem.units import exact, number_advice

LAYOUT = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "floor"},
    "robots": {"count": 9, "capacity": 10_000},
}
PLAIN = "order,item,weight,x,y\nA,p,2.5,1.5,2\nB,q,1,3,4\n"


def read(folder: Path, text: str, **options: Any) -> Instance:
    (folder / "layout.json").write_text(json.dumps(LAYOUT))
    (folder / "x.csv").write_bytes(text.encode())
    return qrobot.read(folder / "x.csv", **options)


def refusal(folder: Path, text: str, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, **options)
    return str(caught.value).removeprefix(f"{folder / 'x.csv'}: ")


GERMAN = PLAIN.replace(",", ";").replace(".", ",")
SHAPES = {
    "sep=": "sep=;\r\n" + GERMAN,
    "sep= in quotes": '"sep=;"\n' + GERMAN,
    "SEP= with a comma": "SEP=,\n" + PLAIN,
    "byte order mark and sep=": "\ufeffsep=;\n" + GERMAN,
    "trailing delimiter": PLAIN.replace("\n", ",\n"),
    "trailing delimiters in the lines only": PLAIN.replace("2\n", "2,,\n").replace("4\n", "4,\n"),
    "trailing delimiter in the header only": PLAIN.replace("y\n", "y,\n").replace("2\n", "2,\n")
    .replace("4\n", "4,\n"),
    "empty column": PLAIN.replace(",x", ",,x").replace("2.5,", "2.5,,").replace("q,1,", "q,1,,"),
    "empty column with a name": PLAIN.replace("y\n", "y,note\n").replace("2\n", "2,\n")
    .replace("4\n", "4,\n"),
    "empty column of another kind of place": PLAIN.replace("y\n", "y,node\n")
    .replace("2\n", "2,\n").replace("4\n", "4,\n"),
    "tabs": PLAIN.replace(",", "\t"),
    "tabs and decimal commas": PLAIN.replace(",", "\t").replace(".", ","),
    "^Z": PLAIN + "\x1a",
    "^Z on a line": PLAIN.replace("\n", "\r\n") + "\x1a",
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_the_same_orders_in_another_shape(tmp_path: Path, shape: str) -> None:
    assert read(tmp_path, SHAPES[shape]) == read(tmp_path, PLAIN)


def test_lines_are_counted_from_the_first_of_the_file(tmp_path: Path) -> None:
    text = "sep=;\n" + GERMAN.replace("2,5", "x")
    assert refusal(tmp_path, text).startswith("line 3, column weight: x is not a finite number")


@pytest.mark.parametrize("sign", ["|", ":", " "])
def test_another_separator_is_refused(tmp_path: Path, sign: str) -> None:
    assert refusal(tmp_path, f"sep={sign}\n" + PLAIN.replace(",", sign)).startswith(
        f"line 1: the separator {sign!r} is not known; use , ; or a tab"
    )


def test_a_column_without_a_name_that_holds_something(tmp_path: Path) -> None:
    text = PLAIN.replace(",x", ",,x").replace("2.5,", "2.5,7,").replace("q,1,", "q,1,,")
    assert refusal(tmp_path, text).startswith("line 1: column 4 has no name, but line 2 fills it")


def test_columns_that_are_not_ours(tmp_path: Path) -> None:
    text = PLAIN.replace("y\n", "y,Note,node\n").replace("2\n", "2,fragile,7\n")
    text = text.replace("3,4\n", "3,4,,8\n")
    assert "did you mean 'node'? If not, give --ignore-columns note" in refusal(
        tmp_path, PLAIN.replace("y\n", "y,note\n").replace("2\n", "2,x\n").replace("4\n", "4,\n")
    )
    assert read(tmp_path, text, ignore_columns=["note", "NODE"]) == read(tmp_path, PLAIN)
    for name, why in (("weight", "needed"), ("customer", "not in the header")):
        assert f"column {name!r} cannot be ignored: it is {why}" in refusal(
            tmp_path, text, ignore_columns=[name]
        )
    (tmp_path / "x.json").write_text(json.dumps({**LAYOUT, "items": []}))
    with pytest.raises(InputError, match="columns belong to CSV orders"):
        qrobot.read(tmp_path / "x.json", ignore_columns=["note"])


def test_an_article_of_an_order_from_two_places(tmp_path: Path) -> None:
    one = read(tmp_path, PLAIN + "A,p,1,7,7\nB,p,1,7,7\n")
    assert [(i.id, i.weight) for i in one.items] == [
        ("A/p#1", Fraction(5, 2)), ("q", 1), ("A/p#2", 1), ("B/p", 1),
    ]  # fmt: skip
    assert one.orders == (Order("A", ("A/p#1", "A/p#2")), Order("B", ("q", "B/p")))
    assert "item 'p' of order 'A' is in line 2 too" in refusal(tmp_path, PLAIN + "A,p,1,1.5,2\n")
    assert "has the same name as line 4, 'A/p#2'" in refusal(
        tmp_path, PLAIN + "A,p,1,7,7\nB,p,1,7,7\nB,A/p#2,1,0,0\n"
    )


def test_a_header_alone_is_told(tmp_path: Path) -> None:
    for text in ("order,item,weight,x,y\n", "order,item,weight,x,y\n,,,,\n"):
        one = read(tmp_path, text)
        assert one.size == 0
        assert one.notes == ("the file has a header but no orders",)
    assert read(tmp_path, PLAIN).notes == ()


CASES = [
    # delimiter, other numbers, cell, what it means (None: refused), what to write
    (";", "2,5", "1.234", None, "write 1234, or 1,234"),
    (";", "2,5", "1,234", "1.234", ""),
    (";", "2,5", "1.234.567", None, "write 1234567"),
    (";", "2,5", "1.234,5", None, "write 1234,5"),
    (";", "2,5", "3.5", "3.5", ""),
    (";", "7", "1.234", None, "write 1234, or 1,234"),
    (";", "7", "1,234", "1.234", ""),
    (";", "0.5", "1.234", "1.234", ""),
    (";", "0.5", "1,234", None, "write 1234, or 1.234"),
    (";", "0.5 0,5", "1,234", None, "write 1234, or 1,234"),
    ("\t", "2,5", "1.234", None, "write 1234, or 1,234"),
    ("\t", "2,5", "1,234", "1.234", ""),
    ("\t", "7", "1.234", "1.234", ""),
    ("\t", "7", "1,234", None, "write 1234, or 1.234"),
    ("\t", "0.5", "1,234", None, "write 1234, or 1.234"),
    (",", "0.5", "1,234", None, "write 1234, or 1.234"),
    (",", "0.5", "2,5", None, "write 2.5"),
    (",", "0.5", "1,234.5", None, "write 1234.5"),
    (",", "0.5", "1,234,567", None, "write 1234567"),
    (",", "0.5", "1.234", "1.234", ""),
    (",", "0.5", "1 234", None, "write 1234"),
    (",", "0.5", "1'234.5", None, "write 1234.5"),
    (",", "0.5", "1\u202f234", None, "write 1234"),
    (",", "0.5", "1_234", None, "write 1234"),
    (",", "0.5", "１２", None, ""),
    (",", "0.5", "1e3", "1000", ""),
]


@pytest.mark.parametrize(("delimiter", "others", "cell", "means", "advice"), CASES)
def test_what_a_number_means(
    tmp_path: Path, delimiter: str, others: str, cell: str, means: str | None, advice: str
) -> None:
    rows = [["order", "item", "weight", "x", "y"]]
    rows += [[f"o{k}", f"i{k}", other, "0", "0"] for k, other in enumerate(others.split())]
    rows.append(["last", "last", cell, "0", "0"])
    text = "\n".join(delimiter.join(f'"{c}"' if delimiter in c else c for c in r) for r in rows)
    if means is None:
        said = refusal(tmp_path, text)
        assert said.startswith(f"line {len(rows)}, column weight: "), said
        assert advice in said
    else:
        assert read(tmp_path, text).items[-1].weight == Fraction(means)


def grouped(number: Decimal, group: str, mark: str) -> str:
    text = f"{number:,f}"
    return text.replace(",", "_").replace(".", mark).replace("_", group)


@given(
    st.decimals(0, 10**9, places=3).map(lambda d: d.normalize()),
    st.sampled_from([(",", "."), (".", ","), ("'", "."), ("\u00a0", ","), ("", "."), ("", ",")]),
    st.sampled_from(",;\t"),
    st.lists(st.sampled_from(["2,5", "0.5", "7", "1.234", "1,234"]), max_size=2),
)
def test_no_number_is_read_as_another(
    number: Decimal, style: tuple[str, str], delimiter: str, others: list[str]
) -> None:
    """Where others of the file are written in the same style, the number is right or refused."""
    group, mark = style
    text = grouped(number, group, mark)
    same = [other for other in others if other in ("7", f"2{mark}5", f"0{mark}5")]
    if f"2{mark}5" not in same and f"0{mark}5" not in same and delimiter != ",":
        same.append(f"0{mark}5")
    if delimiter == "," and mark == ",":
        same = []
    found, advice = Fraction(number), "none is needed"
    try:
        found = exact(DecimalMarks.of(delimiter, [*same, text]).plain(text), field="")
    except InputError as error:
        advice = error.advice or ""
    assert found == Fraction(number)
    assert advice


@given(st.text("0123456789.,'_ -+", max_size=12), st.sampled_from(".,"))
def test_what_the_advice_says_to_write_is_read(text: str, mark: str) -> None:
    advice = number_advice(text, mark)
    if advice.startswith("write "):
        for option in advice.removeprefix("write ").split(":")[0].split(", or "):
            assert exact(option.replace(",", "."), field="") is not None


@pytest.mark.parametrize("value", ["1,234", "1.234,5", "1 234", "1_000", "nan", "１２", "0x10", ""])
def test_capacity_on_the_command_line_is_read_the_same_way(tmp_path: Path, value: str) -> None:
    with pytest.raises(InputError, match=r"capacity: .*is not a finite number; (write|use)"):
        read(tmp_path, PLAIN, capacity=value)
