"""Plans that are better than the best published ones are what the page says of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import qrobot
from qrobot.warehouse import Router

PROJECT = Path(__file__).parents[2]
SHARED = PROJECT.parent / "shared/data/picking"
BEST = json.loads((PROJECT / "benchmarks/results/henn_best.json").read_text())


@pytest.mark.skipif(not SHARED.is_dir(), reason="the published files are not here")
@pytest.mark.parametrize("entry", BEST, ids=[Path(entry["file"]).stem for entry in BEST])
def test_batches_have_the_value_that_is_told(entry: dict) -> None:
    instance = qrobot.read(SHARED / entry["file"])
    batches = entry["batches"]
    assert sorted(order for batch in batches for order in batch) == sorted(
        order.id for order in instance.orders
    )
    items = {item.id: item for item in instance.items}
    of_order = {order.id: [items[i] for i in order.items] for order in instance.orders}
    router = Router(instance.warehouse, compiled=False)  # the plain sweep
    total = 0.0
    for batch in batches:
        picks = [item for order in batch for item in of_order[order]]
        assert sum(item.weight for item in picks) <= instance.robots[0].capacity
        total += router.length([item.place for item in picks])
    assert total == pytest.approx(entry["value"])
    published = json.loads((SHARED / "index.json").read_text())
    (known,) = [e["value"] for e in published if e["file"] == entry["file"]]
    assert total < known == entry["published"]
