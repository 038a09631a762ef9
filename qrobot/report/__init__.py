"""What people see of plans: pictures and tables."""

from qrobot.report.picture import check_picture_path, plot
from qrobot.report.tables import table

__all__ = ["check_picture_path", "plot", "table"]
