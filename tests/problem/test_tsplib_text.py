"""TSPLIB's text as written: what is a keyword, what changes the question, what depends on what."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance

HEADER = [
    "NAME : own-n4-k2",
    "COMMENT : (own)",
    "TYPE : CVRP",
    "DIMENSION : 4",
    "EDGE_WEIGHT_TYPE : EXPLICIT",
    "EDGE_WEIGHT_FORMAT : FULL_MATRIX",
    "CAPACITY : 10",
]
SECTIONS = [
    "EDGE_WEIGHT_SECTION\n0 4 7 9\n5 0 3 2\n7 3 0 6\n9 2 6 0",
    "DEMAND_SECTION\n1 0\n2 4\n3 5\n4 2.5",
    "DEPOT_SECTION\n 1\n -1",
]
PLAIN = "\n".join([*HEADER, *SECTIONS, "EOF\n"])


def read(folder: Path, text: str, **options: object) -> Instance:
    (folder / "x.vrp").write_text(text, encoding="utf-8")
    return qrobot.read(folder / "x.vrp", **options)  # type: ignore[arg-type]


def refusal(folder: Path, text: str, **options: object) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, **options)
    return str(caught.value).removeprefix(f"{folder / 'x.vrp'}: ")


WORDS = [
    "GEOFFREY", "EOF", "eof", "CROSS_SECTION DATA", "DEMAND_SECTION", "DEPOT_SECTION", "TYPE : TSP",
    "DIMENSION : 9", "NAME : other", "-1", "a:b:c", "EOF.", "EDGE_WEIGHT_SECTION :",
]  # fmt: skip


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("field", ["NAME", "COMMENT"])
def test_keywords_inside_of_texts_are_text(tmp_path: Path, field: str, word: str) -> None:
    text = "\n".join(
        [f"NAME : {word} -k2" if field == "NAME" else HEADER[0],
         f"COMMENT : x {word}" if field == "COMMENT" else HEADER[1],
         *HEADER[2:], *SECTIONS, "EOF"]
    )  # fmt: skip
    one = read(tmp_path, text)
    assert one.distances.tolist() == read(tmp_path, PLAIN).distances.tolist()
    assert word in (one.name if field == "NAME" else one.comment)


@settings(max_examples=60, deadline=None)
@given(st.permutations([*HEADER, *SECTIONS]))
def test_fields_and_sections_stand_in_any_sequence(
    tmp_path_factory: pytest.TempPathFactory, blocks: list[str]
) -> None:
    folder = tmp_path_factory.mktemp("vrp")
    assert read(folder, "\n".join([*blocks, "EOF"])) == read(folder, PLAIN)


def test_nodes_stand_in_any_sequence(tmp_path: Path) -> None:
    shuffled = PLAIN.replace("1 0\n2 4\n3 5\n4 2.5", "4 2.5\n2 4\n1 0\n3 5")
    assert read(tmp_path, shuffled) == read(tmp_path, PLAIN)


# Fields of public dialects (VRPLIB as PyVRP documents it, CMT, Golden, Li, LKH) and made-up ones.
CHANGING = [
    "VEHICLES_MAX_DISTANCE", "VEHICLES_MAX_DURATION", "VEHICLES_MAX_RELOADS", "VEHICLES_FIXED_COST",
    "VEHICLES_UNIT_DISTANCE_COST", "MAX_DURATION", "MAX_DISTANCE", "DISTANCE", "DURATION",
    "TIME_LIMIT", "SERVICE_TIME", "SALESMEN", "DEPOTS", "EDGE_DATA_FORMAT", "SCALE", "UNIT_COST",
    "MIN_VEHICLES", "CAPACITY_VOL", "GROUPS", "RELOADS", "PROFIT", "NEVER HEARD OF",
]  # fmt: skip


@pytest.mark.parametrize("field", CHANGING)
@pytest.mark.parametrize("last", [False, True])
def test_an_unknown_field_is_refused_with_its_line(tmp_path: Path, field: str, last: bool) -> None:
    lines = PLAIN.removesuffix("EOF\n")
    text = f"{lines}{field} : 30\nEOF\n" if last else f"{field} : 30\n{PLAIN}"
    said = refusal(tmp_path, text)
    line = text.split("\n").index(f"{field} : 30") + 1
    assert said.startswith(f"{field}, line {line}: 30 asks for something that qRobot does not plan")
    assert "remove the field if plans may ignore it" in said


@pytest.mark.parametrize("section", ["TIME_WINDOW", "SERVICE_TIME", "BACKHAUL", "FIXED_EDGES", "X"])
def test_an_unknown_section_is_refused(tmp_path: Path, section: str) -> None:
    text = PLAIN.replace("DEPOT_SECTION", f"{section}_SECTION\n1 2\nDEPOT_SECTION")
    assert refusal(tmp_path, text).startswith(f"{section}_SECTION, line 18: is more than qRobot")


@pytest.mark.parametrize("field", ["AUTHOR", "DATE", "URL", "LICENSE"])
def test_a_field_that_only_describes_is_noted(tmp_path: Path, field: str) -> None:
    one = read(tmp_path, f"{field} : somebody\n{PLAIN}")
    assert one == read(tmp_path, PLAIN)
    assert read(tmp_path, f"{field} : x\n{PLAIN}").notes[0] == (
        f"the field {field} (line 1) is not read"
    )


@pytest.mark.parametrize("field", ["DISTANCE", "SERVICE_TIME", "VEHICLES_FIXED_COST"])
def test_a_limit_of_zero_is_none(tmp_path: Path, field: str) -> None:
    assert read(tmp_path, f"{field} : 0\n{PLAIN}") == read(tmp_path, PLAIN)


def test_what_is_given_twice(tmp_path: Path) -> None:
    for line in HEADER:
        name, _, value = line.partition(" : ")
        again = read(tmp_path, f"{PLAIN.removesuffix('EOF' + chr(10))}{line}\nEOF\n")
        assert again.distances.tolist() == read(tmp_path, PLAIN).distances.tolist()
        if name != "COMMENT":
            said = refusal(tmp_path, f"{line}0\n{PLAIN}")
            assert f"{name}, line " in said
            assert f"is given where line 1 has '{value}0'; keep one of them" in said
    for section in SECTIONS:
        name = section.split("\n")[0]
        said = refusal(tmp_path, PLAIN.replace("EOF", f"{section}\nEOF"))
        assert said.startswith(f"{name}, line 21: is given in line ")
    two = read(tmp_path, PLAIN.replace("(own)", "(own)\nCOMMENT : No of trucks: 3"))
    assert two.comment == "(own) No of trucks: 3"
    assert len(two.robots) == 3


def test_what_stands_behind_the_end_is_noted(tmp_path: Path) -> None:
    assert read(tmp_path, PLAIN + "\n \n").notes == read(tmp_path, PLAIN).notes
    one = read(tmp_path, PLAIN + "\nMAX_DISTANCE : 3\n")
    assert one.notes[0] == "line 23 and what follows stand behind EOF and are not read"


@pytest.mark.parametrize("value", ["-1", "9999", "1e300", "-0.5", "0"])
def test_the_diagonal_is_not_used(tmp_path: Path, value: str) -> None:
    rows = [line.split() for line in SECTIONS[0].split("\n")[1:]]
    for i in range(4):
        rows[i][i] = value
    text = PLAIN.replace(
        SECTIONS[0], "EDGE_WEIGHT_SECTION\n" + "\n".join(" ".join(row) for row in rows)
    )
    one = read(tmp_path, text)
    assert one.place_distances.tolist() == read(tmp_path, PLAIN).place_distances.tolist()
    qrobot.write(one, tmp_path / "again.json")
    assert qrobot.read(tmp_path / "again.json").place_distances.tolist() == (
        one.place_distances.tolist()
    )


def test_the_type_of_an_asymmetric_problem(tmp_path: Path) -> None:
    assert read(tmp_path, PLAIN.replace("CVRP", "ACVRP")) == read(tmp_path, PLAIN)
    assert "TYPE, line 3: TSP is not planned" in refusal(tmp_path, PLAIN.replace("CVRP", "TSP"))


def test_a_missing_format_is_missing(tmp_path: Path) -> None:
    said = refusal(tmp_path, PLAIN.replace(HEADER[5] + "\n", ""))
    assert said.startswith("EDGE_WEIGHT_FORMAT: is missing; use one of FULL_MATRIX, LOWER_ROW")
    said = refusal(tmp_path, PLAIN.replace("EXPLICIT", "EUC_2D"))
    assert said.startswith("EDGE_WEIGHT_SECTION, line 8: stands beside EDGE_WEIGHT_TYPE EUC_2D")


FLOOR = PLAIN.replace(SECTIONS[0], "NODE_COORD_SECTION\n1 0 0\n2 3.3 4\n3 0 5.2\n4 1 1")
FLOOR = FLOOR.replace(HEADER[4], "EDGE_WEIGHT_TYPE : EUC_2D").replace(HEADER[5] + "\n", "")


@pytest.mark.parametrize("kind", ["EUC_2D", "MAN_2D", "CEIL_2D", "FLOOR_2D", "MAX_2D"])
def test_another_rounding(tmp_path: Path, kind: str) -> None:
    text = FLOOR.replace("EUC_2D", kind)
    exact = read(tmp_path, text, rounding="none").distances[0, 1]
    expected = {"MAN_2D": 7.3, "MAX_2D": 4.0}.get(kind, (3.3**2 + 16) ** 0.5)
    assert exact == pytest.approx(expected)
    for rounding, by_rounding in (("up", -(-exact // 1)), ("down", exact // 1)):
        assert read(tmp_path, text, rounding=rounding).distances[0, 1] == by_rounding
    assert read(tmp_path, text, rounding="nearest").distances[0, 1] == (exact + 0.5) // 1
    assert "rounding: 'half' is not a rounding; use one of none, nearest" in refusal(
        tmp_path, text, rounding="half"
    )


def test_rounding_belongs_to_coordinates(tmp_path: Path) -> None:
    assert "rounding: EDGE_WEIGHT_TYPE EXPLICIT leaves nothing to round" in refusal(
        tmp_path, PLAIN, rounding="none"
    )
    qrobot.write(read(tmp_path, PLAIN), tmp_path / "x.json")
    with pytest.raises(InputError, match=r"rounding: rounding belongs to \.vrp files"):
        qrobot.read(tmp_path / "x.json", rounding="none")


def test_small_distances_that_were_rounded_are_told(tmp_path: Path) -> None:
    small = FLOOR.replace("3.3 4", "0.3 0.4").replace("0 5.2", "0 1").replace("4 1 1", "4 0.9 1")
    said = "distances are rounded to whole numbers as EUC_2D demands; the largest is 1"
    assert read(tmp_path, small).notes[0].startswith(said)
    assert read(tmp_path, small, rounding="none").notes == ()
    assert "as CEIL_2D demands" in read(tmp_path, small.replace("EUC_2D", "CEIL_2D")).notes[0]
    large = FLOOR.replace("3.3 4", "330 400").replace("0 5.2", "0 520").replace("4 1 1", "4 100 1")
    assert read(tmp_path, large).notes == ()
    whole = FLOOR.replace("3.3 4", "0 4").replace("5.2", "2").replace("4 1 1", "4 0 1")
    assert read(tmp_path, whole).notes == ()  # nothing was lost


SOLUTIONS = ["77.7", "nan", "inf", "-inf", "-5", "0", "81,5", "1e999", "1e-12", "x", "784"]


@pytest.mark.parametrize(
    ("cost", "ending"), [*itertools.product(SOLUTIONS, [".sol", ".opt.sol", ".bst.sol"])]
)
def test_a_solution_beside_never_changes_the_question(
    tmp_path: Path, cost: str, ending: str
) -> None:
    alone = read(tmp_path, FLOOR)
    (tmp_path / f"x{ending}").write_text(f"Route #1: 1 2\nRoute #2: 3\nCost {cost}\n")
    beside = read(tmp_path, FLOOR)
    assert beside.warehouse == alone.warehouse
    assert beside.distances.tolist() == alone.distances.tolist()
    good = {"77.7": 77.7, "784": 784.0}
    assert beside.reference == good.get(cost)
    if cost not in good:
        assert any(f"x{ending} is passed over" in note for note in beside.notes)
    if cost == "77.7":
        assert any("the reference 77.7 is not whole" in note for note in beside.notes)
    qrobot.write(beside, tmp_path / "again.json")
    assert qrobot.read(tmp_path / "again.json").reference == beside.reference


@pytest.mark.parametrize(
    ("comment", "reference", "noted"),
    [
        ("Optimal value: 784)", 784, False), ("Best known: 27591", 27591, False),
        ("Optimal value: 1,034", None, True), ("Optimal value: 1.034,5", None, True),
        ("Optimal value: nan", None, True), ("Optimal value: inf", None, True),
        ("Optimal value: -5", None, True), ("Optimal value: 0", None, True),
        ("Optimal value: 1_000", None, True), ("Optimal value: unknown", None, False),
        ("Optimal value: 784, trucks 3", 784, False), ("suboptimal value: 3", None, False),
        ("524.61", 524.61, True), ("784", 784, False), ("made in 1969", None, False),
    ],
)  # fmt: skip
def test_the_value_in_a_comment(
    tmp_path: Path, comment: str, reference: float | None, noted: bool
) -> None:
    one = read(tmp_path, FLOOR.replace("(own)", comment))
    assert one.reference == reference
    assert bool(one.remarks) == noted


@pytest.mark.parametrize("number", ["1,000", "1.000", "1'000", "2_000", "5.5"])
def test_a_number_of_trucks_that_is_not_plain_is_not_cut(tmp_path: Path, number: str) -> None:
    one = read(tmp_path, FLOOR.replace("(own)", f"No of trucks: {number}"))
    assert len(one.robots) == 2  # of the name
