"""What is written on a picture: readable, whole, on the sheet, in letters that are there."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import CASES, LAYOUT, points, question, shared, slots

from qrobot._numbers import number
from qrobot.plan import Plan
from qrobot.problem import Instance, Node, OpenFloor, Order, Point, Slot
from qrobot.report import plot
from qrobot.report.fonts import OWN, choose, font_notes
from qrobot.report.picture import draw, style
from qrobot.report.scene import Scene, scene_of

pytest.importorskip("matplotlib")

HOUSES = {
    "aisles": (LAYOUT, lambda n: slots(LAYOUT, n)),
    "floor": (OpenFloor(25.0, 25.0), points),
    "manhattan": (OpenFloor(24.5, 24.5, metric="manhattan"), points),
    "table": (CASES["table"].warehouse, lambda n: [Node(1 + k % 7) for k in range(n)]),
}
LONG = "Kommissionierroboter der Halle Nordost mit Kühlfach"


def case(house: str, trips: int, long: bool, per_robot: int = 1) -> tuple[Instance, Plan]:
    place, where = HOUSES[house]
    instance = question(place, where(max(3 * trips, 4)), robots=-(-trips // per_robot))
    robots = tuple(replace(robot, trips=per_robot) for robot in instance.robots)
    if long:
        robots = tuple(replace(r, id=f"{LONG} {k} $x$") for k, r in enumerate(robots, 1))
        items = tuple(replace(i, id=f"{LONG} {k} $y$") for k, i in enumerate(instance.items, 1))
        instance = replace(instance, name=LONG * 9, items=items,
                           orders=tuple(Order(i.id, (i.id,)) for i in items))  # fmt: skip
    instance = replace(instance, robots=robots)
    return instance, shared(instance, trips)


def figure_of(scene: Scene) -> Any:
    from qrobot.report.draw_aisles import draw_aisles
    from qrobot.report.draw_floor import draw_floor

    house = scene.instance.warehouse
    return draw_aisles(scene) if house == LAYOUT else draw_floor(scene)


def written(figure: Any) -> list[tuple[str, Any]]:
    """All texts that are shown, with their boxes as Matplotlib measures them."""
    from matplotlib.text import Text

    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    off = [axis for axes in figure.axes if not axes.axison for axis in (axes.xaxis, axes.yaxis)]

    def texts(artist: Any) -> Iterator[Any]:
        if isinstance(artist, Text):
            yield artist
        for child in artist.get_children():
            if child not in off:
                yield from texts(child)

    return [
        (text.get_text(), text.get_window_extent(renderer))
        for text in texts(figure)
        if text.get_visible() and text.get_text().strip()
    ]


@pytest.mark.parametrize(
    "trips", [1, 5, 12, *(pytest.param(many, marks=pytest.mark.slow) for many in (13, 23, 60))]
)
@pytest.mark.parametrize("house", HOUSES)
def test_no_text_covers_another_or_leaves_the_sheet(house: str, trips: int) -> None:
    both = [(False, 3), (True, 1)]
    for long, per_robot in both if trips < 60 else both[len(house) % 2 :][:1]:
        instance, plan = case(house, trips, long, per_robot)
        scene = scene_of(plan, instance)
        with style(scene.texts()):
            figure = figure_of(scene)
            texts = written(figure)
            sheet = figure.bbox
        for text, box in texts:
            assert sheet.x0 <= box.x0 <= box.x1 <= sheet.x1, text
            assert sheet.y0 <= box.y0 <= box.y1 <= sheet.y1, text
        for (one, a), (two, b) in combinations(texts, 2):
            apart = a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
            assert apart, (one, two)
        shown = [text for text, _ in texts]
        assert scene.title in shown
        assert len({journey.name for journey in scene.journeys}) == trips
        for journey in scene.journeys:
            assert journey.tag in shown
            assert journey.name in shown


@pytest.mark.parametrize("per_robot", [1, 2, 4, 60])
@pytest.mark.parametrize("trips", [2, 23, 60])
def test_every_trip_has_a_colour_and_a_number_of_its_own(trips: int, per_robot: int) -> None:
    scene = scene_of(*reversed(case("floor", trips, long=False, per_robot=per_robot)))
    assert len({journey.colour.fill for journey in scene.journeys}) == trips
    assert [journey.tag for journey in scene.journeys] == [f"#{n + 1}" for n in range(trips)]


@pytest.mark.slow
def test_each_of_many_trips_has_a_map_of_its_own(tmp_path: Path) -> None:
    for trips in (12, 13):
        for house in ("aisles", "floor"):
            instance, plan = case(house, trips, long=False)
            plot(plan, tmp_path / "plan.svg", instance)
            text = (tmp_path / "plan.svg").read_text()
            for n in range(1, trips + 1):
                assert text.count(f'id="trip-{n}-way"') == 1
                assert text.count(f'id="alone-trip-{n}-way"') == (trips > 12)


def test_both_trips_at_a_slot_show_their_numbers() -> None:
    spots = [Slot(2, 3), Slot(4, 1), Slot(6, 8)]
    instance = question(LAYOUT, [*spots, *spots], robots=2)
    plan = Plan.from_routes(instance, [[1, 2, 3], [4, 5, 6]])
    scene = scene_of(plan, instance)
    with style():
        texts = [text for text, _ in written(figure_of(scene))]
    aisles = [str(k) for k in range(1, LAYOUT.aisles)]
    for stop in ("1", "2", "3"):
        assert texts.count(stop) == 2 + aisles.count(stop)


@given(st.floats(-1e15, 1e15) | st.integers(-(10**15), 10**15) | st.floats(-300, 300))
def test_a_number_has_no_loose_point_and_keeps_its_value(value: float) -> None:
    text = number(value)
    assert not text.endswith(".")
    assert not ("." in text and "e" not in text and text.endswith("0"))
    assert text != "-0"
    assert float(text) == pytest.approx(value, rel=0.006, abs=1e-300)
    assert abs(float(text) - value) <= max(0.5 if abs(value) >= 9999.9 else 0.00501, 0)


@pytest.mark.parametrize("value", [277.0000001, 276.9999999, 277.004, 100.0, 1000.001])
def test_nearly_whole_numbers_are_whole(value: float) -> None:
    assert number(value) == f"{value:.0f}"


def test_dollar_signs_are_parts_of_a_name(tmp_path: Path) -> None:
    instance = question(OpenFloor(), [Point(10, 0), Point(0, 10), Point(10, 10)])
    names = ["$x^2$", "a  b", r"\frac{1}$"]
    items = tuple(replace(i, id=name) for i, name in zip(instance.items, names, strict=True))
    robots = tuple(replace(r, id=f"${r.id}^$") for r in instance.robots)
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    instance = replace(instance, items=items, orders=orders, robots=robots, name="$$ & $")
    plot(shared(instance), tmp_path / "plan.svg", instance)
    text = (tmp_path / "plan.svg").read_text()
    assert "$x^2$" in text
    assert "a b (" in text
    assert "$R1^$" in text


# --- letters ----------------------------------------------------------------------------------

FAMILIES = {
    OWN: "abc é",
    "Noto Sans CJK JP": "日本語",
    "Noto Sans CJK KR": "한국日",
    "Noto Sans Thai": "กข",
    "Zen Antique": "日本語กข",
    "Last Resort": "日本語กข한국𓀀🤖",
    "Noto Color Emoji": "🤖",
}


def covers(family: str, characters: frozenset[str]) -> frozenset[str]:
    return characters & frozenset(FAMILIES[family])


@pytest.mark.parametrize(
    ("needed", "families", "missing"),
    [
        ("abc", [OWN], ""),
        ("a\n\u200d\u0301", [OWN], ""),
        ("日本a", [OWN, "Noto Sans CJK JP"], ""),
        ("日ก", [OWN, "Zen Antique"], ""),
        ("日한", [OWN, "Noto Sans CJK KR"], ""),
        ("กข", [OWN, "Noto Sans Thai"], ""),
        ("日本한กข", [OWN, "Zen Antique", "Noto Sans CJK KR"], ""),
        ("a𓀀🤖", [OWN], "𓀀🤖"),
        ("日𓀀", [OWN, "Noto Sans CJK JP"], "𓀀"),
    ],
)
def test_the_fonts_that_are_there_are_chosen(
    needed: str, families: list[str], missing: str
) -> None:
    assert choose(needed, lambda: FAMILIES, covers) == (families, missing)


def test_without_need_nobody_is_asked() -> None:
    def installed() -> Iterable[str]:
        raise AssertionError("looked for fonts")

    assert choose("abc", installed, covers) == ([OWN], "")


def test_what_is_missing_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    (note,) = font_notes("日本", ["日本"])
    assert "日本" in note
    assert "CJK" in note
    assert "fonts-noto" in note
    assert font_notes("", ["abc"]) == []
    monkeypatch.setattr("qrobot.report.fonts._orders", lambda: False)
    assert "3.11" in font_notes("", ["קופסה"])[0]
    assert font_notes("", ["abc"]) == []


def named(instance: Instance, name: str) -> Instance:
    items = tuple(replace(i, id=f"{name}{k}") for k, i in enumerate(instance.items))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    return replace(instance, items=items, orders=orders)


@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["日本", "한국", "ไทย", "देव", "קופסה", "صندوق", "é", "𓀀"])
def test_other_scripts_are_drawn_or_told_without_warnings(
    name: str,
    alone: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """With the fonts of this machine, and with Matplotlib's own alone."""
    from qrobot.report import fonts

    if alone:
        monkeypatch.setattr(fonts, "_installed", dict)
    instance = named(question(OpenFloor(), points(3)), name)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        notes = draw(shared(instance), tmp_path / "plan.png", instance)
        assert draw(shared(instance), tmp_path / "plan.svg", instance) == ()
    assert seen == []
    assert capfd.readouterr() == ("", "")
    _, missing = fonts.families([name])
    assert len(notes) == bool(missing)
    assert name in (tmp_path / "plan.svg").read_text()
    if notes:
        with pytest.warns(UserWarning, match="no installed font") as told_by_plot:
            plot(shared(instance), tmp_path / "plan.png", instance)
        assert told_by_plot[0].filename == __file__
    if alone:
        assert set(missing) == set(name) - set("éקופסהصندوقे")


def test_no_library_warns_a_user(tmp_path: Path) -> None:
    """A home that cannot be written, and letters that no font has."""
    from qrobot.report.fonts import families

    rare = next((c for c in "🤖𐎀𒀀𓀀𖠀𞤀" if families([c])[1]), None)
    if rare is None:
        pytest.skip("this machine has fonts for everything")
    instance = named(question(OpenFloor(), points(3)), rare)
    file = tmp_path / "instance.json"
    from qrobot.problem.formats import write

    write(instance, file)
    (tmp_path / "home").write_text("not a folder")
    done = subprocess.run(
        [sys.executable, "-m", "qrobot", "solve", file, "--max-work", "10", "-q", "-p", "plan.png"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={"HOME": str(tmp_path / "home"), "PATH": "/usr/bin:/bin",
             "PYTHONPATH": str(Path(__file__).parents[2]), "MPLCONFIGDIR": "/proc/nowhere"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("qrobot: note: no installed font has 1 of the characters")
