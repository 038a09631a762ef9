"""What the tests of the reproduction share: rows, and answers found by trying everything.

>>> from reproductions import done, every_read, row_of, shortest
"""

from __future__ import annotations

from itertools import permutations
from typing import Any

import dimod
import numpy as np
from oracles import assignments

from qrobot.models import PickingModel
from qrobot.problem import Instance
from qrobot.study.reproduce.methods import METHODS
from qrobot.study.reproduce.paper import PaperRow, paper_rows
from qrobot.study.reproduce.question import Outcome

__all__ = ["blank", "done", "every_read", "row_of", "shortest"]


def row_of(table: int, items: int) -> PaperRow:
    return next(row for row in paper_rows(table) if row.items == items)


def blank(row: PaperRow, method: str) -> Outcome:
    return Outcome(
        row.table, row.items, row.robots, row.capacity, 0, method, METHODS[method].backend
    )


def every_read(model: PickingModel) -> tuple[np.ndarray, np.ndarray]:
    """Return all bit strings of a model and the distance that each decodes to."""
    bits = assignments(model.num_variables)
    samples = dimod.SampleSet.from_samples_bqm((bits, model.variables), model.bqm)
    return bits, model.decode_all(samples).distances


def shortest(instance: Instance) -> float:
    d = instance.distances
    return min(
        float(sum(d[a, b] for a, b in zip((0, *tour), (*tour, 0), strict=True)))
        for tour in permutations(range(1, instance.size + 1))
    )


def done(report: dict[str, Any]) -> list[dict[str, Any]]:
    return [line for line in report["lines"] if line["status"] == "done"]
