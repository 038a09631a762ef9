"""What people see of plans: pictures, pick lists and tables."""

from qrobot.report.comparison import PolicyComparison, compare_routing
from qrobot.report.gantt import draw_schedule
from qrobot.report.geojson import geojson, geojson_text
from qrobot.report.picklist import PickLists, pick_lists
from qrobot.report.picklist_page import picklist_page
from qrobot.report.picture import check_picture_path, plot
from qrobot.report.schedules import Schedule
from qrobot.report.scheduling import schedule
from qrobot.report.tables import table

__all__ = [
    "PickLists",
    "PolicyComparison",
    "Schedule",
    "check_picture_path",
    "compare_routing",
    "draw_schedule",
    "geojson",
    "geojson_text",
    "pick_lists",
    "picklist_page",
    "plot",
    "schedule",
    "table",
]
