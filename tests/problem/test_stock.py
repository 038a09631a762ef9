"""Scattered storage: articles that lie in several places, with a quantity in each."""

from __future__ import annotations

import dataclasses
import itertools
import json
from pathlib import Path

import pytest

import qrobot
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Place, Robot, Slot, Stock
from qrobot.study.variants import variant_of

NEAR, FAR = Slot(0, 0), Slot(2, 3)
STOCK = (Stock("nut", NEAR, 2), Stock("nut", FAR, 4), Stock("bolt", FAR, 1))


OTHER = Item("z", 1, Slot(1, 1))


def make(*items: Item, stock: tuple[Stock, ...] = STOCK) -> Instance:
    return Instance(
        AisleWarehouse(aisles=3, slots=4),
        items,
        (Order("1", [item.id for item in items]),),
        (Robot("R1", 100),),
        stock=stock,
    )


def nuts(name: str, place: Place, quantity: int, article: str = "nut") -> Item:
    return Item(name, quantity, place, quantity=quantity, article=article)


def test_items_have_a_first_choice_and_the_demand_adds_up(tmp_path: Path) -> None:
    one = make(nuts("a", NEAR, 2), nuts("b", FAR, 1), nuts("c", FAR, 1, "screw"))
    assert one.demand == {"nut": 3}
    assert any("several places" in note for note in one.notes)
    qrobot.write(one, tmp_path / "x.json")
    again = qrobot.read(tmp_path / "x.json")
    assert again == one
    assert again.stock == STOCK
    assert '"stock"' not in (tmp_path / "x.json").read_text().split('"items"')[0]
    qrobot.write(dataclasses.replace(one, stock=()), tmp_path / "y.json")
    assert "stock" not in (tmp_path / "y.json").read_text()


@pytest.mark.parametrize(
    ("items", "stock", "said"),
    [
        (
            [nuts("a", NEAR, 3)],
            STOCK,
            "items[0].at: 3 pieces of article 'nut' are asked for in slot",
        ),
        ([nuts("a", FAR, 4), nuts("b", FAR, 1)], STOCK, "items[1].at: 1 pieces of article 'nut'"),
        ([nuts("a", FAR, 7)], STOCK, "items[0].quantity: 7 pieces of article 'nut' are asked for"),
        ([nuts("a", Slot(1, 1), 1)], STOCK, "items[0].at: 1 pieces of article 'nut' are asked"),
        (
            [OTHER],
            (Stock("nut", NEAR, 0),),
            "stock[0]: 0 pieces are too few; use 1 or more, or remove",
        ),
        (
            [OTHER],
            (Stock("", NEAR, 1),),
            "stock[0]: an article without a name; name it as items do",
        ),
        (
            [OTHER],
            STOCK[:1] * 2,
            "stock[1]: article 'nut' is in slot 0 of aisle 0, block 0 twice; give",
        ),
        (
            [OTHER],
            (Stock("nut", Slot(3, 0), 1),),
            "stock[0].at.aisle: aisle 3 is outside the layout (ar",
        ),
    ],
)
def test_less_in_stock_than_asked_for_is_refused(
    items: list[Item], stock: tuple[Stock, ...], said: str
) -> None:
    with pytest.raises(InputError) as caught:
        make(*items, stock=stock)
    assert str(caught.value).startswith(said)
    assert "; " in str(caught.value)


HI = """\
TYPE : Single_picker_routing_with_scattered_storage
NUM_AISLES : 3
NUM_CELLS : 4
DEPOT_AISLE : 0
DEPOT_LOCATION : bottom
DISTANCE_AISLE_TO_AISLE : 3
DISTANCE_CELL_TO_CELL : 1
DISTANCE_TOP_TO_CELL : 1
DISTANCE_BOTTOM_TO_CELL : 1
DISTANCE_TOP_OR_BOTTOM_TO_DEPOT : 0
ARTICLE_SECTION
NUM_ARTICLES : 2
ID 0
ID 1
SKU_SECTION
NUM_SKUS : 4
ID 0 AISLE 2 CELL 0 QUANTITY 4 LEFT_RIGHT_HAND_SIDE left
ID 0 AISLE 0 CELL 3 QUANTITY 2 LEFT_RIGHT_HAND_SIDE left
ID 1 AISLE 2 CELL 0 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ID 1 AISLE 1 CELL 0 QUANTITY 0 LEFT_RIGHT_HAND_SIDE left
ORDER_SECTION
NUM_ARTICLES : 2
ID 0 QUANTITY 3
ID 1 QUANTITY 1
EOF
"""


def test_a_file_has_all_places_and_takes_the_nearest_first(tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text(HI)
    one = qrobot.read(tmp_path / "x.txt")
    assert set(one.stock) == {Stock("0", FAR, 4), Stock("0", NEAR, 2), Stock("1", FAR, 1)}
    assert [(i.id, i.place, i.quantity) for i in one.items] == [
        ("1/0#1", NEAR, 2), ("1/0#2", FAR, 1), ("1/1", FAR, 1),
    ]  # fmt: skip
    assert one.demand == {"0": 3, "1": 1}
    (tmp_path / "x.txt").write_text(HI.replace("ID 1 QUANTITY 1", "ID 1 QUANTITY 2"))
    with pytest.raises(InputError, match=r"line 24: more pieces of article 1 are asked for than"):
        qrobot.read(tmp_path / "x.txt")


# -- the files that lie beside the project -----------------------------------------

DATA = Path(__file__).parents[3] / "shared" / "data" / "picking"
INDEX = json.loads((DATA / "index.json").read_text()) if DATA.exists() else []
SCATTERED = [entry for entry in INDEX if entry["problem"] == "SPRP-SS"]

shared = pytest.mark.skipif(not INDEX, reason="no files of pickers in ../shared/data")


@shared
def test_the_shared_files_have_enough_of_everything() -> None:
    assert len(SCATTERED) == 36
    for entry in SCATTERED:
        one = qrobot.read(DATA / entry["file"])
        assert len(one.robots) == len(one.orders) == 1
        assert sum(one.demand.values()) == sum(item.quantity for item in one.items)


def shortest(one: Instance) -> float:
    """Return the length of the best tour over every choice of a place for each unit article."""
    places = [[s.place for s in one.stock if s.article == item.article] for item in one.items]
    flat = [place for options in places for place in options]
    rows = {place: i for i, place in enumerate(flat, 1)}
    far = one.warehouse.distance_matrix(flat)
    return min(
        sum(far[a, b] for a, b in itertools.pairwise([0, *tour, 0]))
        for chosen in itertools.product(*places)
        for tour in itertools.permutations(rows[place] for place in chosen)
    )


@shared
@pytest.mark.parametrize("variant", [None, "two_blocks"])
def test_the_published_values_come_out_of_places_and_quantities(variant: str | None) -> None:
    small = [entry for entry in SCATTERED if "unit_F2" in entry["file"] and "_a3_" in entry["file"]]
    small += [entry for entry in SCATTERED if "unit_F5_m10_C180_a3" in entry["file"]]
    assert len(small) == 2
    for entry in small:
        one = qrobot.read(DATA / entry["file"])
        one = one if variant is None else variant_of(one, variant)
        assert shortest(one) == pytest.approx(entry[variant or "value"])
