"""What docs/formats.md says about orders, limits and errors is what the code does.

That its documents can be read is held by tests/pages.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from pages.blocks import ROOT, blocks_of

import qrobot
from qrobot._formats import known_formats
from qrobot.problem import MAX_ITEMS, MAX_STOPS
from qrobot.problem.aisles import MAX_CROSSINGS
from qrobot.problem.formats.registry import formats_of

PAGE = ROOT / "docs" / "formats.md"

pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="the docs are not in a wheel")


@pytest.fixture
def document() -> dict[str, Any]:
    """Return the first document of the page."""
    first: dict[str, Any] = json.loads(blocks_of(PAGE, "json")[0].text)
    return first


@pytest.fixture
def folder(tmp_path: Path, document: dict[str, Any]) -> Path:
    """Return a folder with its layout."""
    layout = {key: value for key, value in document.items() if key not in ("items", "orders")}
    (tmp_path / "layout.json").write_text(json.dumps(layout))
    return tmp_path


def test_the_table_is_that_of_the_registry() -> None:
    rows = re.findall(r"^\| `(\.\w+)` \| (.+) \| (yes|no) \|$", PAGE.read_text(), re.MULTILINE)
    known = known_formats()
    assert [suffix for suffix, *_ in rows] == [suffix for suffix, *_ in known]
    for (suffix, name, _), (_, text, written) in zip(known, rows, strict=True):
        assert text.startswith(name)
        assert written == ("yes" if any(one.write for one in formats_of(suffix)) else "no")


def test_the_orders_are_read_with_the_first_layout(folder: Path) -> None:
    (folder / "orders.csv").write_text(blocks_of(PAGE, "csv")[0].text)
    one = qrobot.read(folder / "orders.csv")
    assert [i.id for i in one.items] == ["drill", "A1/screws", "A2/screws"]
    assert one.items[1].weight == 1


def test_the_limits_are_those_of_the_code() -> None:
    text = PAGE.read_text()
    assert f"{MAX_ITEMS:,} items at {MAX_STOPS:,} stops" in text
    assert f"{MAX_CROSSINGS:,} crossings" in text


def test_the_errors_are_those_of_the_code(folder: Path, document: dict[str, Any]) -> None:
    drill, screws = document["items"]
    far = drill | {"at": drill["at"] | {"slot": 14}}
    items = [*(screws | {"id": f"{k}"} for k in range(3)), far]
    wave = {k: v for k, v in document.items() if k != "orders"} | {"items": items}
    (folder / "wave.json").write_text(json.dumps(wave))
    header = blocks_of(PAGE, "csv")[0].text.splitlines()[0]
    rows = [f"A{k},bolt,{weight},1,1,0,0,left" for k, weight in enumerate("11111")]
    (folder / "orders.csv").write_text("\n".join([header, *rows, 'B,bolt,"1,234",1,1,0,0,left']))
    places = "\n".join(f"{k} {k} 0" for k in range(1, 33))
    demands = "\n".join(f"{k} {int(k > 1)}" for k in range(1, 13))
    (folder / "A-n32-k5.vrp").write_text(
        "NAME : A-n32-k5\nTYPE : CVRP\nDIMENSION : 32\nEDGE_WEIGHT_TYPE : EUC_2D\nCAPACITY : 100\n"
        f"NODE_COORD_SECTION\n{places}\nDEMAND_SECTION\n{demands}\nDEPOT_SECTION\n1\n-1\nEOF\n"
    )
    (told,) = [b.text for b in blocks_of(PAGE, "text") if "wave.json" in b.text]
    for line in told.splitlines():
        with pytest.raises(qrobot.InputError) as caught:
            qrobot.read(folder / line.partition(":")[0])
        found = str(caught.value).removeprefix(f"{folder}/")
        # The file of the page is not this one, line by line.
        place = r"(?<=slot), line \d+, column \d+"
        assert re.sub(place, "", found) == re.sub(place, "", line)
        assert re.search(place, found) or "slot" not in line
