"""What is asked: warehouse, items, orders, robots; distances; readers and writers."""

from qrobot.problem.aisles import AisleWarehouse
from qrobot.problem.entities import Item, Order, Robot, Stock
from qrobot.problem.floor import OpenFloor
from qrobot.problem.instance import Instance
from qrobot.problem.table import DistanceTable
from qrobot.problem.times import Times
from qrobot.problem.validity import MAX_ITEMS, MAX_STOPS
from qrobot.problem.warehouse import Node, Place, Point, Slot, Warehouse

__all__ = [
    "MAX_ITEMS",
    "MAX_STOPS",
    "AisleWarehouse",
    "DistanceTable",
    "Instance",
    "Item",
    "Node",
    "OpenFloor",
    "Order",
    "Place",
    "Point",
    "Robot",
    "Slot",
    "Stock",
    "Times",
    "Warehouse",
]
