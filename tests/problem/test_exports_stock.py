"""Articles of an export that lie in several places."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from exports import read, refusal
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.report import pick_lists

STOCK = (
    "article,weight,place,stock\nnut,1,FAR,9\nnut,1,NEAR,3\nbolt,2,NEAR,5\nnut,1,EMPTY,0\n"
    "screw,1,FAR,\n"
)
BINS = "label,aisle,block,slot\nFAR,2,1,3\nNEAR,0,0,0\nEMPTY,1,0,0\n"
WANTED = "order,article,quantity\nA,nut,2\nA,bolt,1\nB,nut,8\nB,screw,1\n"


def test_an_article_in_several_places_with_a_stock(tmp_path: Path) -> None:
    one = read(tmp_path, {}, orders=WANTED, locations=BINS, articles=STOCK)
    assert [(s.article, s.label, s.quantity) for s in one.stock] == [
        ("nut", "FAR", 9), ("nut", "NEAR", 3), ("bolt", "NEAR", 5),
    ]  # fmt: skip
    assert [(i.id, i.article, i.label, i.quantity, i.weight) for i in one.items] == [
        ("A/nut", "nut", "FAR", 2, 2), ("bolt", "bolt", "NEAR", 1, 2),
        ("B/nut#1", "nut", "FAR", 7, 7), ("B/nut#2", "nut", "NEAR", 1, 1),
        ("screw", "", "FAR", 1, 1),
    ]  # fmt: skip
    alone = read(
        tmp_path, {}, orders="order,article,quantity\nA,nut,3\n", locations=BINS, articles=STOCK
    )
    (only,) = pick_lists(qrobot.solve(alone, max_work=200)).lists
    assert [(pick.location, pick.item.quantity) for pick in only.picks] == [("NEAR", 3)]


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.lists(st.integers(0, 6), min_size=2, max_size=3),
    st.lists(
        st.tuples(st.integers(1, 5), st.sampled_from(["", "FAR", "NEAR"])), min_size=1, max_size=4
    ),
)
def test_lines_take_what_is_there(
    tmp_path: Path, pieces: list[int], lines: list[tuple[int, str]]
) -> None:
    """Every bin gives what it has at most, every line gets what it asks for, or it is told."""
    labels = ["FAR", "NEAR", "EMPTY"]
    stock = "".join(f"nut,1,{name},{n}\n" for name, n in zip(labels, pieces, strict=False))
    wanted = "".join(f"O{k},nut,{n},{name}\n" for k, (n, name) in enumerate(lines))
    there = dict(zip(labels, pieces, strict=False))
    own = {name: sum(n for n, at in lines if at == name) for name in labels}
    enough = sum(n for n, _ in lines) <= sum(pieces) and all(
        own[name] <= there.get(name, 0) for name in labels
    )
    files = {
        "orders": f"order,article,quantity,place\n{wanted}",
        "articles": f"article,weight,place,stock\n{stock}",
    }
    if not enough:
        said = refusal(tmp_path, {}, locations=BINS, **files)
        assert re.match(r"wave\.csv: line \d+", said), said
        return
    one = read(tmp_path, {}, locations=BINS, **files)
    for name in labels:
        assert sum(i.quantity for i in one.items if i.label == name) <= there.get(name, 0)
    items = {item.id: item for item in one.items}
    for order, (n, name) in zip(one.orders, lines, strict=True):
        assert sum(items[i].quantity for i in order.items) == n
        assert not name or [items[i].label for i in order.items] == [name]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("NEAR,3", "NEAR,", "wave.articles.csv: line 3, column place: article 'nut' is in line 2"),
        ("NEAR,3", "NEAR,x", "wave.articles.csv: line 3, column stock: x is not a finite number"),
        (
            "nut,1,NEAR",
            "nut,2,NEAR",
            "wave.articles.csv: line 3, column weight: article 'nut' is in",
        ),
        (
            "nut,1,NEAR",
            "nut,1,FAR",
            "wave.articles.csv: line 3, column place: article 'nut' is in sl",
        ),
        (
            "FAR,9",
            "FAR,2",
            "wave.csv: line 4, column quantity: 8 pieces of article 'nut' are asked",
        ),
        ("nut,1,NEAR", "nut,1,NAER", "wave.articles.csv: line 3, column place: 'NAER' is not in"),
    ],
)
def test_a_stock_that_cannot_be(tmp_path: Path, old: str, new: str, said: str) -> None:
    found = refusal(
        tmp_path, {}, orders=WANTED, locations=BINS, articles=STOCK.replace(old, new, 1)
    )
    assert found.startswith(said), found
