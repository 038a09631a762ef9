"""Make the maps here: one hall as an occupancy map, as a building map of Open-RMF, and as LIF.

Run it from the project: ``python examples/maps/make_maps.py [FOLDER]``.
"""

from __future__ import annotations

import json
import sys
from itertools import pairwise
from pathlib import Path

from qrobot._files import write_bytes_atomic, write_text_atomic

WIDE, HIGH, CELL = 16.0, 10.0, 0.1
"""Of the hall and of a cell of its map, metres."""

RACKS = [(2.5 + 3 * k, 2.4, 1.2, 5.2) for k in range(4)]
"""Left, low, width and height, metres."""

PILLAR = (14.6, 5.0, 0.4, 0.4)

AISLES = {"A": 1.7, "B": 4.6, "C": 7.6, "D": 10.6, "E": 13.6}
"""Where robots drive between the racks, x in metres."""

SHELVES = {f"{aisle}{n}": (x, 1.5 + 1.7 * n) for aisle, x in AISLES.items() for n in (1, 2, 3)}
POSES = {"dock": (1.0, 1.0), **SHELVES}

ORDERS = {
    "order-1": [("drill", "2.5", "A3"), ("screws", "0.25", "C1")],
    "order-2": [("ladder", "9", "E2")],
    "order-3": [("paint", "4.8", "B2"), ("brush", "0.4", "B3")],
    "order-4": [("saw", "3.2", "D1"), ("gloves", "0.25", "D3")],
    "order-5": [("lamp", "1.5", "E3")],
    "order-6": [("tiles", "7.5", "A1"), ("glue", "1.2", "C2")],
}


def pixels() -> bytes:
    """Return the map as PGM: 254 free, 0 occupied, 205 unknown, as map savers write them."""
    columns, rows = round(WIDE / CELL), round(HIGH / CELL)
    lines = []
    for row in reversed(range(rows)):
        y = (row + 0.5) * CELL
        line = bytearray()
        for column in range(columns):
            x = (column + 0.5) * CELL
            wall = not (0.2 < x < WIDE - 0.2 and 0.2 < y < HIGH - 0.2)
            solid = any(a < x < a + w and b < y < b + h for a, b, w, h in [*RACKS, PILLAR])
            hidden = x > 15 and y > 8.5  # a corner that nobody looked into
            line.append(0 if wall or solid else 205 if hidden else 254)
        lines.append(bytes(line))
    return f"P5\n{columns} {rows}\n255\n".encode() + b"".join(lines)


def lanes() -> tuple[dict[str, tuple[float, float]], list[tuple[str, str, bool]]]:
    """Return the vertices, and the lanes: from, to, and whether they lead both ways.

    The aisles are driven upwards in A, C and E and downwards in B and D.
    """
    vertices, ways = dict(POSES), []
    for k, (aisle, x) in enumerate(AISLES.items()):
        low, high = f"{aisle} front", f"{aisle} back"
        vertices[low], vertices[high] = (x, 1.0), (x, 8.8)
        chain = [low, f"{aisle}1", f"{aisle}2", f"{aisle}3", high]
        ways += [(a, b, False) for a, b in pairwise(chain if k % 2 == 0 else chain[::-1])]
    for end in ("front", "back"):
        ways += [(a, b, True) for a, b in pairwise(f"{aisle} {end}" for aisle in AISLES)]
    return vertices, [("dock", "A front", True), *ways]


def building() -> str:
    """Return the hall as the traffic editor saves it: pixels of 2 cm, y downwards."""
    vertices, ways = lanes()
    number = {name: k for k, name in enumerate(vertices)}
    pixel = 0.02
    rows = [
        f"      - [{x / pixel:.1f}, {(HIGH - y) / pixel:.1f}, 0, {json.dumps(name)}]"
        for name, (x, y) in vertices.items()
    ]
    tracks = [
        f"      - [{number[a]}, {number[b]}, {{bidirectional: [4, {str(both).lower()}], "
        f"graph_idx: [2, 0], speed_limit: [3, {'0.5' if a == 'dock' else '0'}]}}]"
        for a, b, both in ways
    ]
    first, last = number["A front"], number["A back"]
    return "\n".join(
        [
            "coordinate_system: reference_image",
            "name: hall",
            "levels:",
            "  L1:",
            "    elevation: 0",
            "    lanes:",
            *tracks,
            "    measurements:",
            f"      - [{first}, {last}, {{distance: [3, 7.8]}}]",
            "    vertices:",
            *rows,
            "lifts: {}\n",
        ]
    )


def lif() -> str:
    """Return the hall as LIF: the shelves are stations."""
    vertices, ways = lanes()
    rules = [{"vehicleTypeId": "cart", "vehicleOrientation": 0.0}]
    edges = [(a, b) for a, b, _ in ways] + [(b, a) for a, b, both in ways if both]
    layout = {
        "layoutId": "hall",
        "layoutVersion": "1",
        "nodes": [
            {
                "nodeId": f"n-{name.replace(' ', '-')}",
                "mapId": "hall",
                "nodePosition": {"x": x, "y": y},
                "vehicleTypeNodeProperties": [{"vehicleTypeId": "cart"}],
            }
            for name, (x, y) in vertices.items()
        ],
        "edges": [
            {
                "edgeId": f"e-{k}",
                "startNodeId": f"n-{a.replace(' ', '-')}",
                "endNodeId": f"n-{b.replace(' ', '-')}",
                "vehicleTypeEdgeProperties": rules,
            }
            for k, (a, b) in enumerate(edges, 1)
        ],
        "stations": [{"stationId": name, "interactionNodeIds": [f"n-{name}"]} for name in POSES],
    }
    about = {
        "projectIdentification": "hall",
        "creator": "qRobot's examples",
        "exportTimestamp": "2026-11-28T12:00:00.00Z",
        "lifVersion": "1.0.0",
    }
    return json.dumps({"metaInformation": about, "layouts": [layout]}, indent=1) + "\n"


def question(name: str, warehouse: dict[str, object]) -> str:
    """Return the orders in one of these warehouses."""
    items = [
        f'    {{"id": "{item}", "weight": {weight}, "at": {{"pose": "{pose}"}}}}'
        for lines in ORDERS.values()
        for item, weight, pose in lines
    ]
    orders = [
        json.dumps({"id": order, "items": [item for item, *_ in lines]})
        for order, lines in ORDERS.items()
    ]
    return (
        '{\n  "schema": "qrobot.instance/1",\n'
        f'  "name": "{name}",\n'
        '  "comment": "Hall and orders are ours; see examples/maps/make_maps.py.",\n'
        f'  "warehouse": {json.dumps(warehouse)},\n'
        '  "robots": {"count": 2, "capacity": 18, "speed": 0.8},\n'
        '  "items": [\n' + ",\n".join(items) + "\n  ],\n"
        '  "orders": [\n    ' + ",\n    ".join(orders) + "\n  ]\n}\n"
    )


def main(folder: Path) -> None:
    """Write every map and the questions on them."""
    write_bytes_atomic(folder / "hall.pgm", pixels())
    texts = {
        "hall.yaml": f"image: hall.pgm\nmode: trinary\nresolution: {CELL}\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        "hall.poses.yaml": "poses:\n"
        + "".join(f"  {name}: [{x:g}, {y:g}]\n" for name, (x, y) in POSES.items()),
        "hall.building.yaml": building(),
        "hall.lif": lif(),
        "on-map.json": question(
            "hall", {"kind": "map", "file": "hall.yaml", "depot": "dock", "radius": 0.3}
        ),
        "on-lanes.json": question(
            "hall-lanes", {"kind": "lanes", "file": "hall.building.yaml", "depot": "dock"}
        ),
        "on-lif.json": question("hall-lif", {"kind": "lanes", "file": "hall.lif", "depot": "dock"}),
    }
    for name, text in texts.items():
        write_text_atomic(folder / name, text)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
