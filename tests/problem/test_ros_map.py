"""Maps of files: pixels as nav2's map server takes them, poses beside them, and their faults."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import qrobot
from qrobot.errors import InputError
from qrobot.problem import FloorMap, Pose
from qrobot.problem.formats.native import to_text
from qrobot.problem.formats.ros_map import read_poses, read_ros_map

FIELDS = {
    "image": "m.pgm", "resolution": 0.5, "origin": [0, 0, 0], "negate": 0,
    "occupied_thresh": 0.65, "free_thresh": 0.196,
}  # fmt: skip


def write_map(folder: Path, pixels: Any, name: str = "m.pgm", **fields: Any) -> Path:
    """Write an image and its YAML; ``None`` leaves a field out."""
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / name)
    data = {**FIELDS, "image": name, **fields}
    path = folder / "m.yaml"
    path.write_text("".join(f"{k}: {v}\n" for k, v in data.items() if v is not None))
    return path


def rows(path: Path) -> tuple[str, ...]:
    return read_ros_map(path)[0]


def test_dark_is_occupied_and_what_is_between_is_unknown(tmp_path: Path) -> None:
    # 1 - 89/255 = .651, 1 - 90/255 = .647; 1 - 206/255 = .192, 1 - 205/255 = .19608
    assert rows(write_map(tmp_path, [[0, 89, 90], [205, 206, 254]])) == ("##?", "?..")


def test_unknown_cells_that_a_threshold_makes_free_are_told(tmp_path: Path) -> None:
    *_, remarks = read_ros_map(write_map(tmp_path, [[205, 254]], free_thresh=0.25))
    assert remarks == (
        "m.yaml: free_thresh 0.25 makes 1 cell free whose pixel is 205, by which map savers mean "
        "unknown (0.196 does not)",
    )
    assert read_ros_map(write_map(tmp_path, [[206, 254]], free_thresh=0.25))[-1] == ()
    assert read_ros_map(write_map(tmp_path, [[205, 254]]))[-1] == ()


def test_negate_turns_dark_and_light(tmp_path: Path) -> None:
    assert rows(write_map(tmp_path, [[255, 100, 0]], negate=1)) == ("#?.",)
    assert rows(write_map(tmp_path, [[255, 100, 0]], negate="true")) == ("#?.",)


def test_plain_pgm_is_read(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[0]])
    (tmp_path / "m.pgm").write_text("P2\n# by hand\n3 2\n255\n0 205 254\n254 254 254\n")
    assert rows(path) == ("#?.", "...")
    (tmp_path / "m.pgm").write_text("P2\n3 1\n1000\n0 500 1000\n")  # 16 bits a pixel
    assert rows(path) == ("#?.",)


def test_raw_pixels_are_percents(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[0, 19, 20, 65, 66, 100, 101, 255]], mode="raw", negate=1)
    assert rows(path) == ("..??##??",)


def test_transparent_pixels(tmp_path: Path) -> None:
    white = [[[255, 255, 255, 255], [255, 255, 255, 0], [0, 0, 0, 255]]]
    # Trinary: opacity is a fourth colour, so a clear white pixel is a quarter dark.
    assert rows(write_map(tmp_path, white, "m.png")) == (".?#",)
    assert rows(write_map(tmp_path, white, "m.png", free_thresh=0.3)) == ("..#",)
    assert rows(write_map(tmp_path, white, "m.png", mode="scale", free_thresh=0.3)) == (".?#",)


def test_colours_count_by_their_mean(tmp_path: Path) -> None:
    assert rows(write_map(tmp_path, [[[255, 0, 0], [255, 255, 160]]], "m.png")) == ("#.",)


def test_numbers_that_yaml_takes_for_text_are_numbers(tmp_path: Path) -> None:
    _, side, origin, _ = read_ros_map(
        write_map(tmp_path, [[254]], resolution="5e-2", origin="[-1.5, 2e0]")
    )
    assert (side, origin) == (0.05, (-1.5, 2.0, 0.0))


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"resolution": None}, "resolution: is missing; add it"),
        ({"image": None}, "image: is missing"),
        ({"image": "other.pgm"}, r"cannot read '.*other.pgm': No such file"),
        ({"origin": 3}, "origin: is not a list of at least 2"),
        ({"origin": "[0, north, 0]"}, r'origin\[1\]: "north" is not a number'),
        ({"mode": "ternary"}, "mode: 'ternary' is not a mode; use trinary, scale, raw"),
        ({"free_thresh": 0.7}, "free_thresh: 0.7 and occupied_thresh 0.65 are not two shares"),
        ({"negate": "maybe"}, 'negate: "maybe" is not a number'),
        ({"origin": "[0, 0"}, "broken YAML .*; correct it"),
    ],
)
def test_faults_of_a_map_are_told(tmp_path: Path, fields: dict[str, Any], problem: str) -> None:
    path = write_map(tmp_path, [[254]])
    data = {**FIELDS, **fields}
    path.write_text("".join(f"{k}: {v}\n" for k, v in data.items() if v is not None))
    with pytest.raises(InputError, match=problem):
        read_ros_map(path)


@pytest.mark.parametrize("damage", [b"", b"P5\n9 9\n255\nxx", b"GIF89a", b"not an image"])
def test_a_broken_image_is_told(tmp_path: Path, damage: bytes) -> None:
    path = write_map(tmp_path, [[254]])
    (tmp_path / "m.pgm").write_bytes(damage)
    with pytest.raises(InputError, match=r"m\.pgm: cannot be read as an image; save it as PGM"):
        read_ros_map(path)


def test_a_huge_image_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[254]])
    for size in (20_000, 60_000):
        (tmp_path / "m.pgm").write_bytes(f"P5\n{size} {size}\n255\n".encode())
        with pytest.raises(InputError, match=r"m\.pgm"):
            read_ros_map(path)


# -- poses --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("p.yaml", "poses:\n  dock: [0.5, 1.5]\n  B 2: {x: 2, y: 1.0, yaw: 3.1}\n"),
        ("p.yaml", "dock: {x: 0.5, y: 1.5}\nB 2: [2, 1, 0]\n"),
        ("p.csv", "name,x,y\ndock,0.5,1.5\nB 2,2,1\n\n"),
        ("p.csv", "X;yaw;Name;Y\n0,5;0;dock;1,5\n2;1,57;B 2;1\n"),
    ],
)
def test_poses_are_read(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    assert read_poses(tmp_path / name) == (("dock", (0.5, 1.5)), ("B 2", (2.0, 1.0)))


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("p.yaml", "dock: 3\n", "poses.dock: is 3, not a mapping"),
        ("p.yaml", "dock: [1]\n", "poses.dock: is not a list of at least 2"),
        ("p.yaml", "dock: {x: 1}\n", "poses.dock.y: null is not a number"),
        ("p.yaml", "- dock\n", "is a list, not a mapping"),
        ("p.csv", "name,x\n", "line 1: has no column y; give name, x and y"),
        ("p.csv", "name,x,y\ndock,1,zwei\n", 'line 2, column y: "zwei" is not a number'),
        ("p.csv", "name,x,y\n,1,2\n", "line 2, column name: is empty"),
        ("p.csv", "name,x,y\ndock,1\n", 'line 2, column y: "" is not a number'),
        ("p.csv", "name,x,y\ndock,1,inf\n", "line 2, column y"),
    ],
)
def test_faults_of_poses_are_told(tmp_path: Path, name: str, text: str, problem: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=problem):
        read_poses(tmp_path / name)


# -- in native JSON -----------------------------------------------------------------

HALL = [
    [0, 0, 0, 0, 0],
    [0, 254, 254, 254, 0],
    [0, 254, 0, 254, 0],
    [0, 254, 254, 254, 0],
    [0, 0, 0, 0, 0],
]
POSES = "dock: [0.75, 0.75]\nleft: [0.75, 1.75]\nright: [1.75, 1.75]\npillar: [1.25, 1.25]\n"


def document(folder: Path, pose: str = "right", **warehouse: Any) -> Path:
    """Write a map, its poses and a question with two items on it."""
    write_map(folder, HALL)
    if not (folder / "poses.yaml").exists():
        (folder / "poses.yaml").write_text(POSES)
    data = {
        "schema": "qrobot.instance/1",
        "warehouse": {"kind": "map", "file": "m.yaml", "depot": "dock", **warehouse},
        "robots": {"count": 1, "capacity": 5},
        "items": [
            {"id": "a", "weight": 1, "at": {"pose": "left"}},
            {"id": "b", "weight": 1, "at": {"pose": pose}},
            {"id": "c", "weight": 1, "at": {"x": 1.75, "y": 0.75}},
        ],
    }
    path = folder / "wave.json"
    path.write_text(json.dumps(data))
    return path


def test_a_question_on_a_map_is_planned_and_checked(tmp_path: Path) -> None:
    instance = qrobot.read(document(tmp_path))
    assert isinstance(instance.warehouse, FloorMap)
    assert [item.place for item in instance.items][:2] == [Pose("left"), Pose("right")]
    result = qrobot.solve(instance, backend="exact")
    # Once round the pillar, two cells of half a metre along each side.
    assert result.plan.distance == pytest.approx(4.0)
    assert result.is_optimal
    assert qrobot.check(result.plan, instance).distance == pytest.approx(4.0)


def test_what_is_written_again_is_complete(tmp_path: Path) -> None:
    instance = qrobot.read(document(tmp_path, radius=0.4))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    qrobot.write(instance, elsewhere / "wave.json")
    again = qrobot.read(elsewhere / "wave.json")
    assert again == instance
    assert to_text(again) == (elsewhere / "wave.json").read_text()
    assert (again.place_distances == instance.place_distances).all()


def test_a_pose_in_a_wall_is_one_sentence_with_file_pose_and_advice(tmp_path: Path) -> None:
    path = document(tmp_path, "pillar")
    with pytest.raises(InputError) as caught:
        qrobot.read(path)
    assert str(caught.value) == (
        f"{path}: items[1].at, line 1, column 228: pose 'pillar' at (1.25, 1.25) of m.yaml lies "
        "in a wall (item 'b'); move it to a free cell"
    )


@pytest.mark.parametrize(
    ("warehouse", "problem"),
    [
        ({"depot": "pillar"}, "wave.json: warehouse.depot, .*pose 'pillar' .* lies in a wall; mo"),
        ({"depot": "dokc"}, "warehouse.depot, .*'dokc' is not a pose of m.yaml; did you mean dock"),
        ({"radius": 0.5}, "warehouse.depot, .*nearer to a wall than the radius of the robots, 0.5"),
        ({"cell": 0.7}, r"warehouse.cell, .*0.7 is not a whole multiple .*, 0.5; give 0.5"),
        ({"cell": 1.0}, "warehouse.depot, .*is in a cell of 1 that is not free all over"),
        ({"cells": ["..", ".."]}, "warehouse.file, .*has both file and cells; give one of them"),
        ({"poses": "none.csv"}, "none.csv: cannot read .*none.csv': No such file"),
        ({"file": "n.yaml"}, "n.yaml: cannot read .*n.yaml': No such file"),
        ({"poses": {"dock": [1]}}, r"warehouse.poses.dock, .*needed: more entries"),
        ({"poses": 3}, r"warehouse.poses, .*3 is not right; needed: an object"),
        ({"depot": {"x": 1}}, "warehouse.depot, .*y: is missing|warehouse.depot.y"),
        ({"raduis": 1}, "warehouse.raduis, .*did you mean 'radius'"),
    ],
)
def test_faults_of_the_document_are_told(
    tmp_path: Path, warehouse: dict[str, Any], problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        qrobot.read(document(tmp_path, **warehouse))


def test_poses_may_stand_in_the_document(tmp_path: Path) -> None:
    (tmp_path / "poses.yaml").write_text("broken: [")
    poses = {"dock": [0.75, 0.75], "left": [0.75, 1.75], "right": [1.75, 1.75]}
    assert qrobot.read(document(tmp_path, poses=poses)).size == 3


def test_what_is_cut_off_is_told(tmp_path: Path) -> None:
    path = document(tmp_path)
    Image.fromarray(np.array([[254, 0, 254], [254, 0, 254], [254, 0, 254]], dtype=np.uint8)).save(
        tmp_path / "m.pgm"
    )
    (tmp_path / "poses.yaml").write_text("dock: [0, 0]\nleft: [0.1, 1]\nright: [1.2, 1]\n")
    data = json.loads(path.read_text())
    data["items"] = data["items"][:2]
    path.write_text(json.dumps(data))
    with pytest.raises(
        InputError, match=r"items\[1\].at, .*no way leads from the depot to items b"
    ):
        qrobot.read(path)


def test_orders_of_a_spreadsheet_name_poses(tmp_path: Path) -> None:
    data = json.loads(document(tmp_path).read_text())
    del data["items"]
    (tmp_path / "layout.json").write_text(json.dumps(data))
    (tmp_path / "orders.csv").write_text("order,item,weight,pose\n1,a,1,left\n1,b,2,right\n")
    instance = qrobot.read(tmp_path / "orders.csv")
    assert [item.place for item in instance.items] == [Pose("left"), Pose("right")]
    (tmp_path / "orders.csv").write_text("order,item,weight,pose\n1,a,1,left\n1,b,2,pillar\n")
    with pytest.raises(InputError, match=r"line 3, column pose: pose 'pillar' .*lies in a wall"):
        qrobot.read(tmp_path / "orders.csv")
