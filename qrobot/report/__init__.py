"""What people and programs see: pictures, tables, benchmarks."""

from qrobot.report.picture import check_picture_path, plot
from qrobot.report.table import table

__all__ = ["check_picture_path", "plot", "table"]
