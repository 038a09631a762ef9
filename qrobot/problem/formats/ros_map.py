"""Occupancy maps of ROS: a YAML file, the image that it names, and named poses beside them.

The image is read as nav2's map server documents it: the darker a pixel, the likelier its cell
is occupied.
"""

from __future__ import annotations

import csv
import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._extras import load
from qrobot._files import read_text, refusal
from qrobot._text import count
from qrobot.errors import InputError
from qrobot.problem.floor_map import FREE, MAX_CELLS, OCCUPIED, UNKNOWN
from qrobot.problem.formats.yamls import listed, mapping, number, read_yaml

__all__ = ["poses_beside", "read_poses", "read_ros_map"]

MODES = ("trinary", "scale", "raw")

Poses = tuple[tuple[str, tuple[float, float]], ...]


UNSEEN = 205
"""What map savers write for an unknown cell."""


def read_ros_map(
    path: Path,
) -> tuple[tuple[str, ...], float, tuple[float, float, float], tuple[str, ...]]:
    """Return the cells of a map, the side of one in metres, where its corner is, and remarks.

    Raises
    ------
    InputError
        When a field is missing or wrong, or the image cannot be read.
    """
    data = read_yaml(path)
    for name in ("image", "resolution", "origin", "occupied_thresh", "free_thresh"):
        if name not in data:
            raise InputError("is missing", field=name, advice="add it, as nav2's map saver does")
    origin = listed(data["origin"], "origin", least=2)
    x, y, yaw = (number(v, f"origin[{i}]") for i, v in enumerate([*origin, 0.0][:3]))
    mode = str(data.get("mode", "trinary")).lower()
    if mode not in MODES:
        raise InputError(f"{mode!r} is not a mode", field="mode", advice=f"use {', '.join(MODES)}")
    free, occupied = (number(data[name], name) for name in ("free_thresh", "occupied_thresh"))
    if not 0 <= free <= occupied <= 1:
        raise InputError(
            f"{free:g} and occupied_thresh {occupied:g} are not two shares, the lesser one first",
            field="free_thresh",
            advice="use 0 to 1, such as 0.196 and 0.65",
        )
    image = Path(str(data["image"]))
    pixels = _pixels(image if image.is_absolute() else path.parent / image)
    taken = _occupancy(pixels, mode, bool(number(_flag(data.get("negate", 0)), "negate")))
    # What is neither clearly free nor clearly occupied counts as unknown, in every mode.
    cells = np.full(taken.shape, ord(UNKNOWN), dtype=np.uint8)
    cells[taken < free] = ord(FREE)
    cells[taken > occupied] = ord(OCCUPIED)
    rows = tuple(row.tobytes().decode("ascii") for row in cells)
    remarks = []
    unseen = int(np.count_nonzero((pixels[:, :, 0] * 255 == UNSEEN) & (taken < free)))
    if unseen and mode == "trinary":
        remarks.append(
            f"{path.name}: free_thresh {free:g} makes {count(unseen, 'cell')} free whose pixel is "
            f"{UNSEEN}, by which map savers mean unknown (0.196 does not)"
        )
    return rows, number(data["resolution"], "resolution"), (x, y, yaw), tuple(remarks)


def _flag(value: Any) -> Any:
    return int(value) if isinstance(value, bool) else value


def _pixels(path: Path) -> npt.NDArray[np.float64]:
    """Return an image as red, green, blue and opacity, each 0 to 1."""
    image_of = load("PIL.Image", "the image of a map")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its size is looked at below
            image = image_of.open(path)
        with image:
            wide, high = image.size
            if wide * high > MAX_CELLS:
                raise InputError(
                    f"{wide} x {high} pixels are more than {MAX_CELLS}",
                    advice="cut the map, or save it at a coarser resolution",
                )
            if image.mode.startswith(("I", "F")):  # 16 bits a pixel
                grey = np.asarray(image, dtype=np.float64) / 65535
                return np.stack([grey, grey, grey, np.ones_like(grey)], axis=2)
            return np.asarray(image.convert("RGBA"), dtype=np.float64) / 255
    except InputError as error:
        raise error.in_file(str(path)) from None
    except OSError as error:
        if error.errno is not None:
            raise refusal("read", str(path), error) from None
        raise _no_image(path) from None
    except (SyntaxError, ValueError, EOFError, IndexError, image_of.DecompressionBombError):
        raise _no_image(path) from None


def _no_image(path: Path) -> InputError:
    return InputError(
        "cannot be read as an image", source=str(path), advice="save it as PGM or PNG again"
    )


def _occupancy(pixels: npt.NDArray[np.float64], mode: str, negate: bool) -> npt.NDArray[np.float64]:
    """Return how likely each cell is occupied, 0 to 1; NaN where it says that it is unknown."""
    opacity = pixels[:, :, 3]
    shade = pixels[:, :, :3].mean(axis=2)
    if mode == "raw":
        percent = np.round(shade * 255)
        return np.where(percent <= 100, percent / 100, np.nan)
    clear = bool((opacity < 1).any())
    if mode == "trinary" and clear:  # as the map server does, opacity is a fourth colour
        shade = pixels.mean(axis=2)
    taken = shade if negate else 1 - shade
    return np.where(opacity < 1, np.nan, taken) if mode == "scale" else taken


# -- named poses --------------------------------------------------------------------


def poses_beside(path: Path) -> Path | None:
    """Return the file of named poses beside a map, None without one."""
    names = [f"{path.stem}.poses.yaml", f"{path.stem}.poses.csv", "poses.yaml", "poses.csv"]
    return next((path.with_name(n) for n in names if path.with_name(n).is_file()), None)


def read_poses(path: Path) -> Poses:
    """Return the named poses of a YAML or a CSV file.

    Raises
    ------
    InputError
        When a pose has no name, or no coordinates.
    """
    if path.suffix.lower() == ".csv":
        return _from_csv(read_text(path))
    data = read_yaml(path)
    found = []
    for name, value in mapping(data.get("poses", data), "poses").items():
        if isinstance(value, list):
            x, y = listed(value, f"poses.{name}", least=2)[:2]
        else:
            pose = mapping(value, f"poses.{name}")
            x, y = pose.get("x"), pose.get("y")
        found.append((name, (number(x, f"poses.{name}.x"), number(y, f"poses.{name}.y"))))
    return tuple(found)


def _from_csv(text: str) -> Poses:
    semicolons = ";" in text.splitlines()[0]
    lines = csv.reader(io.StringIO(text), delimiter=";" if semicolons else ",")
    heads = [cell.strip().lower() for cell in next(lines)]
    if missing := {"name", "x", "y"} - set(heads):
        raise InputError(
            f"has no column {min(missing)}", field="line 1", advice="give name, x and y"
        )
    found = []
    for cells in lines:
        if not any(cell.strip() for cell in cells):
            continue
        row = dict(zip(heads, map(str.strip, cells), strict=False))
        where = f"line {lines.line_num}, column "
        if not row.get("name"):
            raise InputError("is empty", field=f"{where}name", advice="give the pose a name")
        x, y = (
            number(_decimal(row.get(axis, ""), semicolons), where + axis) for axis in ("x", "y")
        )
        found.append((row["name"], (x, y)))
    return tuple(found)


def _decimal(cell: str, comma: bool) -> str:
    """Return a number with a point for its decimal mark, which a comma is beside semicolons."""
    return cell.replace(",", ".") if comma and cell.count(",") == 1 else cell
