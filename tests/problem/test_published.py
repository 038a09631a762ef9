"""Small instances of TSPLIB, solved as one robot that can carry everything.

Coordinates, distances and optima are those that G. Reinelt published (TSPLIB, a traveling
salesman problem library, ORSA Journal on Computing 3, 1991); they are facts, not files.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import qrobot
from qrobot.problem import Instance

BURMA14 = """\
16.47 96.10  16.47 94.44  20.09 92.54  22.39 93.37  25.23 97.24  22.00 96.05  20.47 97.02
17.20 96.29  16.30 97.38  14.05 98.12  16.53 97.38  21.52 95.59  19.41 97.13  20.09 94.55
"""
ULYSSES16 = """\
38.24 20.42  39.57 26.15  40.56 25.32  36.26 23.12  33.48 10.54  37.56 12.19  38.42 13.11
37.52 20.44  41.23 9.10  41.17 13.05  36.08 -5.21  38.47 15.13  38.15 15.35  37.51 15.17
35.49 14.32  39.36 19.56
"""
ATT48 = """\
6734 1453  2233 10  5530 1424  401 841  3082 1644  7608 4458  7573 3716  7265 1268  6898 1885
1112 2049  5468 2606  5989 2873  4706 2674  4612 2035  6347 2683  6107 669  7611 5184  7462 3590
7732 4723  5900 3561  4483 3369  6101 1110  5199 2182  1633 2809  4307 2322  675 1006  7555 4819
7541 3981  3177 756  7352 4506  7545 2801  3245 3305  6426 3173  4608 1198  23 2216  7248 3779
7762 4595  7392 2244  3484 2829  6271 2135  4985 140  1916 1569  7280 4899  7509 3239  10 2676
6807 2993  5185 3258  3023 1942
"""
ATT48_TOUR = [
    *(8, 38, 31, 44, 18, 7, 28, 6, 37, 19, 27, 17, 43, 30, 36, 46, 33, 20, 47, 21, 32, 39, 48, 5),
    *(42, 24, 10, 45, 35, 4, 26, 2, 29, 34, 41, 16, 22, 3, 23, 14, 25, 13, 11, 12, 15, 40, 9),
]
GR17 = """\
0 633 0 257 390 0 91 661 228 0 412 227 169 383 0 150 488 112 120 267 0 80 572 196 77 351 63 0
134 530 154 105 309 34 29 0 259 555 372 175 338 264 232 249 0 505 289 262 476 196 360 444 402
495 0 353 282 110 324 61 208 292 250 352 154 0 324 638 437 240 421 329 297 314 95 578 435 0 70
567 191 27 346 83 47 68 189 439 287 254 0 211 466 74 182 243 105 150 108 326 336 184 391 145 0
268 420 53 239 199 123 207 165 383 240 140 448 202 57 0 246 745 472 237 528 364 332 349 202 685
542 157 289 426 483 0 121 518 142 84 297 35 29 36 236 390 238 301 55 96 153 336 0
"""
BR17 = """\
9999 3 5 48 48 8 8 5 5 3 3 0 3 5 8 8 5
3 9999 3 48 48 8 8 5 5 0 0 3 0 3 8 8 5
5 3 9999 72 72 48 48 24 24 3 3 5 3 0 48 48 24
48 48 74 9999 0 6 6 12 12 48 48 48 48 74 6 6 12
48 48 74 0 9999 6 6 12 12 48 48 48 48 74 6 6 12
8 8 50 6 6 9999 0 8 8 8 8 8 8 50 0 0 8
8 8 50 6 6 0 9999 8 8 8 8 8 8 50 0 0 8
5 5 26 12 12 8 8 9999 0 5 5 5 5 26 8 8 0
5 5 26 12 12 8 8 0 9999 5 5 5 5 26 8 8 0
3 0 3 48 48 8 8 5 5 9999 0 3 0 3 8 8 5
3 0 3 48 48 8 8 5 5 0 9999 3 0 3 8 8 5
0 3 5 48 48 8 8 5 5 3 3 9999 3 5 8 8 5
3 0 3 48 48 8 8 5 5 0 0 3 9999 3 8 8 5
5 3 0 72 72 48 48 24 24 3 3 5 3 9999 48 48 24
8 8 50 6 6 0 0 8 8 8 8 8 8 50 9999 0 8
8 8 50 6 6 0 0 8 8 8 8 8 8 50 0 9999 8
5 5 26 12 12 8 8 0 0 5 5 5 5 26 8 8 9999
"""


def tour(folder: Path, size: int, kind: str, head: str, data: str) -> Instance:
    """Return the instance of one robot that carries a weight of 1 from every node."""
    demands = "\n".join(f"{k + 1} {int(k > 0)}" for k in range(size))
    (folder / "tour.vrp").write_text(
        f"NAME : tour-k1\nTYPE : {kind}\nDIMENSION : {size}\nCAPACITY : {size}\n{head}\n{data}\n"
        f"DEMAND_SECTION\n{demands}\nDEPOT_SECTION\n1\n-1\nEOF\n"
    )
    return qrobot.read(folder / "tour.vrp")


def coordinates(text: str) -> tuple[int, str]:
    words = text.split()
    size = len(words) // 2
    rows = "\n".join(f"{k + 1} {words[2 * k]} {words[2 * k + 1]}" for k in range(size))
    return size, f"NODE_COORD_SECTION\n{rows}"


@pytest.mark.parametrize(("text", "optimum"), [(BURMA14, 3323), (ULYSSES16, 6859)])
def test_geographical_distances(tmp_path: Path, text: str, optimum: int) -> None:
    size, data = coordinates(text)
    one = tour(tmp_path, size, "CVRP", "EDGE_WEIGHT_TYPE : GEO", data)
    result = qrobot.solve(one, backend="exact", max_work=5000)
    assert (result.cost, result.is_optimal) == (optimum, True)


def test_pseudo_euclidean_distances(tmp_path: Path) -> None:
    size, data = coordinates(ATT48)
    one = tour(tmp_path, size, "CVRP", "EDGE_WEIGHT_TYPE : ATT", data)
    assert sorted(ATT48_TOUR) == list(range(2, 49))
    assert one.length([[node - 1 for node in ATT48_TOUR]]) == 10628
    found = qrobot.solve(one, backend="pyvrp", max_work=1500)
    assert found.bound <= 10628 <= found.cost < 10628 * 1.05


def layouts(matrix: np.ndarray) -> dict[str, str]:
    """Write a symmetric matrix in every EDGE_WEIGHT_FORMAT, as TSPLIB 95 describes them."""
    n = len(matrix)
    cells = {
        "FULL_MATRIX": [(i, j) for i in range(n) for j in range(n)],
        "UPPER_ROW": [(i, j) for i in range(n) for j in range(i + 1, n)],
        "LOWER_ROW": [(i, j) for i in range(n) for j in range(i)],
        "UPPER_DIAG_ROW": [(i, j) for i in range(n) for j in range(i, n)],
        "LOWER_DIAG_ROW": [(i, j) for i in range(n) for j in range(i + 1)],
        "UPPER_COL": [(i, j) for j in range(n) for i in range(j)],
        "LOWER_COL": [(i, j) for j in range(n) for i in range(j + 1, n)],
        "UPPER_DIAG_COL": [(i, j) for j in range(n) for i in range(j + 1)],
        "LOWER_DIAG_COL": [(i, j) for j in range(n) for i in range(j, n)],
    }
    return {name: " ".join(str(matrix[i, j]) for i, j in at) for name, at in cells.items()}


def explicit(layout: str) -> str:
    return f"EDGE_WEIGHT_TYPE : EXPLICIT\nEDGE_WEIGHT_FORMAT : {layout}"


def test_every_layout_of_a_matrix(tmp_path: Path) -> None:
    matrix = np.zeros((17, 17), dtype=int)
    matrix[np.tril_indices(17)] = list(map(int, GR17.split()))
    matrix = matrix + matrix.T
    data = f"EDGE_WEIGHT_SECTION\n{GR17}"
    first = tour(tmp_path, 17, "CVRP", explicit("LOWER_DIAG_ROW"), data)
    assert qrobot.solve(first, backend="exact", max_work=5000).cost == 2085
    for layout, numbers in layouts(matrix).items():
        one = tour(tmp_path, 17, "CVRP", explicit(layout), f"EDGE_WEIGHT_SECTION\n{numbers}")
        assert np.array_equal(one.place_distances, matrix), layout


def test_an_asymmetric_matrix_whose_diagonal_is_no_way(tmp_path: Path) -> None:
    data = f"EDGE_WEIGHT_SECTION\n{BR17}"
    one = tour(tmp_path, 17, "ACVRP", explicit("FULL_MATRIX"), data)
    assert qrobot.solve(one, backend="exact", max_work=5000).cost == 39
    assert any(note.startswith("the distances are asymmetric") for note in one.notes)


@pytest.mark.parametrize(
    ("kind", "width", "expected"),
    [
        ("EUC_2D", 2, 8), ("CEIL_2D", 2, 9), ("FLOOR_2D", 2, 8), ("EXACT_2D", 2, 8485),
        ("MAN_2D", 2, 12), ("MAX_2D", 2, 6), ("EUC_3D", 3, 10), ("MAN_3D", 3, 18),
        ("MAX_3D", 3, 6), ("ATT", 2, 3), ("GEO", 2, 944),
    ],
)  # fmt: skip
def test_one_distance_of_each_kind(tmp_path: Path, kind: str, width: int, expected: float) -> None:
    """From (0, 0, 0) to (6, 6, 6): 8.485, 12, 6; 10.392, 18, 6; sqrt(7.2) = 2.68."""
    point = " 6" * width
    data = f"NODE_COORD_SECTION\n1{' 0' * width}\n2{point}\n3{point}"
    one = tour(tmp_path, 3, "CVRP", f"EDGE_WEIGHT_TYPE : {kind}", data)
    assert one.distances[0, 1] == one.distances[1, 0] == expected
    if kind == "GEO":  # the great circle by another formula, within its cut-off kilometre
        angle = np.arccos(np.cos(np.radians(6)) ** 2)
        assert expected == pytest.approx(6378.388 * angle + 0.5, abs=0.5)


@pytest.mark.parametrize("kind", ["XRAY1", "XRAY2", "SPECIAL", "HAVERSINE", "EUC_4D"])
def test_other_kinds_are_refused(tmp_path: Path, kind: str) -> None:
    with pytest.raises(qrobot.InputError, match=f"EDGE_WEIGHT_TYPE, line 5: {kind} is not known"):
        tour(tmp_path, 2, "CVRP", f"EDGE_WEIGHT_TYPE : {kind}", "NODE_COORD_SECTION\n1 0 0\n2 1 1")
