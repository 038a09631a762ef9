"""Orders in a sheet of a workbook: what `csvs` reads, from another kind of file."""

from __future__ import annotations

from qrobot.problem.formats.csvs import read_orders
from qrobot.problem.formats.registry import builtin

__all__ = ["FORMAT"]

FORMAT = builtin(__name__, read_orders)
