"""What is asked: warehouse, items, orders, robots; distances; readers and writers."""

from qrobot.problem.aisles import AisleWarehouse
from qrobot.problem.entities import Item, Order, Robot, Stock
from qrobot.problem.floor import OpenFloor
from qrobot.problem.floor_map import FloorMap
from qrobot.problem.instance import Instance
from qrobot.problem.lane_network import LaneNetwork
from qrobot.problem.table import DistanceTable
from qrobot.problem.times import Times
from qrobot.problem.validity import MAX_ITEMS, MAX_STOPS
from qrobot.problem.warehouse import Node, Place, Point, Pose, Slot, Warehouse

__all__ = [
    "MAX_ITEMS",
    "MAX_STOPS",
    "AisleWarehouse",
    "DistanceTable",
    "FloorMap",
    "Instance",
    "Item",
    "LaneNetwork",
    "Node",
    "OpenFloor",
    "Order",
    "Place",
    "Point",
    "Pose",
    "Robot",
    "Slot",
    "Stock",
    "Times",
    "Warehouse",
]
