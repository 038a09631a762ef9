"""The question: which robot collects which orders from where.

Everything here is frozen and checked when it is made. The numbers that solvers need
(distances, integer weights) are derived once, on first use.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qrobot.errors import InputError
from qrobot.problem.units import MAX_UNITS, common_unit, exact, in_units
from qrobot.problem.warehouse import DistanceTable, Place, Warehouse

__all__ = ["MAX_ITEMS", "MAX_STOPS", "Instance", "Item", "Order", "Robot"]

MAX_ITEMS = 20_000
"""More items than this are refused: plan them in waves."""

MAX_STOPS = 2_500
"""More stops (places of each order) than this are refused: their distance matrix alone takes
50 MB, and every solver keeps a few of its size (a Pi 4 may have 2 GB)."""


@dataclass(frozen=True, slots=True)
class Item:
    """One thing to collect, from one place.

    Parameters
    ----------
    id
        Unique name.
    weight
        Weight, kg by convention; an exact fraction.
    place
        Where it lies.
    """

    id: str
    weight: Fraction
    place: Place

    def __post_init__(self) -> None:
        """Take a plain number for the decimal that it is written as."""
        if not isinstance(self.weight, Fraction):
            object.__setattr__(self, "weight", exact(self.weight, field="weight"))


@dataclass(frozen=True, slots=True)
class Order:
    """A whole lot of items that stay together on one trip.

    Parameters
    ----------
    id
        Unique name.
    items
        Ids of its items.
    """

    id: str
    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot that collects.

    Parameters
    ----------
    id
        Unique name.
    capacity
        Largest load of one trip, in the unit of the weights.
    speed
        Metres a second, for times in reports; distances do not depend on it.
    trips
        The most trips the robot may make.
    """

    id: str
    capacity: Fraction
    speed: float = 1.0
    trips: int = 1

    def __post_init__(self) -> None:
        """Take a plain number for the decimal that it is written as."""
        if not isinstance(self.capacity, Fraction):
            object.__setattr__(self, "capacity", exact(self.capacity, field="capacity"))


@dataclass(frozen=True)
class Instance:
    """A warehouse, what to collect from it, and who collects.

    Parameters
    ----------
    warehouse
        The layout, floor or table of distances.
    items
        n items; item i is node i + 1 of `distances`, the depot is node 0.
    orders
        Whole lots; every item is in exactly one.
    robots
        The fleet.
    name, comment
        For people.
    reference
        A known value of the least distance, from a benchmark file.

    Raises
    ------
    InputError
        When ids repeat or dangle, a weight is negative, a place is outside the warehouse
        or cannot be reached.
    """

    warehouse: Warehouse
    items: tuple[Item, ...]
    orders: tuple[Order, ...]
    robots: tuple[Robot, ...]
    name: str = "instance"
    comment: str = ""
    reference: float | None = None
    split: bool = field(default=False)

    def __post_init__(self) -> None:
        """Check everything that can be checked without distances."""
        if len(self.items) > MAX_ITEMS:
            raise InputError(
                f"{len(self.items)} items are more than the {MAX_ITEMS} that one plan may have",
                field="items",
                mend="plan them in waves",
            )
        _unique([i.id for i in self.items], "items")
        _unique([o.id for o in self.orders], "orders")
        _unique([r.id for r in self.robots], "robots")
        if not self.robots:
            raise InputError("no robots", field="robots", mend="give at least one robot")
        for i, item in enumerate(self.items):
            if item.weight < 0:
                raise InputError(
                    f"weight {float(item.weight):g} of item {item.id!r} is negative",
                    field=f"items[{i}].weight",
                    mend="use zero or more",
                )
            try:
                self.warehouse.check(item.place)
            except InputError as error:
                path = f"items[{i}].at" + (f".{error.field}" if error.field else "")
                raise InputError(
                    f"{error.problem} (item {item.id!r})", field=path, mend=error.mend
                ) from None
        for i, robot in enumerate(self.robots):
            if robot.capacity <= 0:
                raise InputError(
                    f"capacity {float(robot.capacity):g} of robot {robot.id!r} is not positive",
                    field=f"robots[{i}].capacity",
                    mend="use a number above zero",
                )
            if not (robot.speed > 0 and math.isfinite(robot.speed)):
                raise InputError(
                    f"speed {robot.speed:g} of robot {robot.id!r} is not positive",
                    field=f"robots[{i}].speed",
                    mend="use metres a second above zero",
                )
            if robot.trips < 1:
                raise InputError(
                    f"{robot.trips} trips for robot {robot.id!r} are too few",
                    field=f"robots[{i}].trips",
                    mend="use 1 or more, or remove the robot",
                )
        self._check_orders()

    def _check_orders(self) -> None:
        known = {item.id for item in self.items}
        owner: dict[str, str] = {}
        for i, order in enumerate(self.orders):
            if not order.items:
                raise InputError(
                    f"order {order.id!r} is empty",
                    field=f"orders[{i}].items",
                    mend="name at least one item or remove the order",
                )
            for j, item_id in enumerate(order.items):
                path = f"orders[{i}].items[{j}]"
                if item_id not in known:
                    raise InputError(
                        f"order {order.id!r} names the unknown item {item_id!r}",
                        field=path,
                        mend="add the item or correct the name",
                    )
                if item_id in owner:
                    raise InputError(
                        f"item {item_id!r} is in orders {owner[item_id]!r} and {order.id!r}",
                        field=path,
                        mend="keep it in one order; give a second piece an id of its own",
                    )
                owner[item_id] = order.id
        if len(owner) < len(known):
            missing = sorted(known - set(owner))
            raise InputError(
                f"items {_some(missing)} are in no order",
                field="orders",
                mend="put every item into an order, or leave the orders out",
            )
        place = {item.id: item.place for item in self.items}
        stops = len({(owner[item_id], place[item_id]) for item_id in owner})
        if stops > MAX_STOPS:
            raise InputError(
                f"{stops} stops (places of each order) are more than the {MAX_STOPS} that one plan "
                f"may have: their distances alone would take {8 * (stops + 1) ** 2 / 1e6:.0f} MB",
                field="orders",
                mend="plan them in waves",
            )

    # -- numbers for solvers ---------------------------------------------------------

    @cached_property
    def distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (node 0) and items (node i + 1), shape (n + 1, n + 1).

        Raises
        ------
        InputError
            When an item cannot be reached from the depot or left again.
        """
        matrix = self.place_distances[np.ix_(self.place_of_node, self.place_of_node)]
        matrix.flags.writeable = False
        return matrix

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """The different places that items lie in, in the sequence of the items."""
        return tuple(dict.fromkeys(item.place for item in self.items))

    @cached_property
    def place_of_node(self) -> npt.NDArray[np.intp]:
        """For each node its row in `place_distances`, shape (n + 1,)."""
        row = {place: i + 1 for i, place in enumerate(self.places)}
        return np.array([0, *(row[item.place] for item in self.items)], dtype=np.intp)

    @cached_property
    def place_distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (row 0) and the different places: small however many items.

        Raises
        ------
        InputError
            When an item cannot be reached from the depot or left again.
        """
        matrix = np.ascontiguousarray(self.warehouse.distance_matrix(self.places))
        matrix.flags.writeable = False
        ways = np.isfinite(matrix)
        if not ways.all():
            cut_off = np.flatnonzero(~(ways[0] & ways[:, 0]))
            culprits = cut_off if cut_off.size else np.flatnonzero(~(ways & ways.T).all(axis=0))
            found = np.flatnonzero(np.isin(self.place_of_node, culprits)) - 1
            ids = _some([self.items[i].id for i in found])
            mends = {"aisles": ", or open an aisle", "matrix": ", or fill in their distances"}
            raise InputError(
                f"no way leads from the depot to items {ids} and back"
                if cut_off.size
                else f"some ways between items {ids} are missing",
                field=f"items[{found[0]}].at",
                mend="move the items" + mends.get(self.warehouse.kind, ""),
            )
        return matrix

    @cached_property
    def unit(self) -> Fraction:
        """The largest weight that every item's weight is a whole multiple of."""
        return common_unit([item.weight for item in self.items], field="items")

    @cached_property
    def weights(self) -> npt.NDArray[np.int64]:
        """Item weights in units, shape (n,)."""
        return in_units([item.weight for item in self.items], self.unit)

    @cached_property
    def capacities(self) -> npt.NDArray[np.int64]:
        """Robot capacities in units, rounded down (exact: loads are whole), shape (K,)."""
        return np.array(
            [min(math.floor(r.capacity / self.unit), MAX_UNITS) for r in self.robots],
            dtype=np.int64,
        )

    @cached_property
    def order_nodes(self) -> tuple[tuple[int, ...], ...]:
        """For each order the nodes (item index + 1) of its items."""
        node = {item.id: i + 1 for i, item in enumerate(self.items)}
        return tuple(tuple(node[i] for i in order.items) for order in self.orders)

    @cached_property
    def order_of_node(self) -> npt.NDArray[np.intp]:
        """For each node the index of its order, shape (n + 1,); the depot has -1."""
        found = np.full(len(self.items) + 1, -1, dtype=np.intp)
        for o, nodes in enumerate(self.order_nodes):
            found[list(nodes)] = o
        return found

    @cached_property
    def order_weights(self) -> npt.NDArray[np.int64]:
        """Order weights in units, shape (number of orders,)."""
        return np.array(
            [sum(int(self.weights[v - 1]) for v in nodes) for nodes in self.order_nodes],
            dtype=np.int64,
        )

    @cached_property
    def vehicle_capacities(self) -> npt.NDArray[np.int64]:
        """Capacity of every possible trip in units, largest first, shape (sum of trips,).

        A robot that may make several trips counts as often, but never more often than
        there are orders.
        """
        most = max(len(self.orders), 1)
        repeats = [min(robot.trips, most) for robot in self.robots]
        return np.sort(np.repeat(self.capacities, repeats))[::-1][: max(most, 1)].copy()

    @cached_property
    def whole_orders(self) -> bool:
        """Whether some order has several stops, so that its items must be kept together."""
        return len(self.stops) > len(self.orders)

    @cached_property
    def stops(self) -> tuple[tuple[int, ...], ...]:
        """Nodes of each stop: items of one order in one place are collected at one stop."""
        found: dict[tuple[int, Place], list[int]] = {}
        for o, nodes in enumerate(self.order_nodes):
            for node in nodes:
                found.setdefault((o, self.items[node - 1].place), []).append(node)
        return tuple(tuple(nodes) for nodes in found.values())

    @cached_property
    def stop_distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (row 0) and stops, shape (number of stops + 1,) twice."""
        rows = self.place_of_node[[0, *(nodes[0] for nodes in self.stops)]]
        matrix = self.place_distances[np.ix_(rows, rows)]
        matrix.flags.writeable = False
        return matrix

    @cached_property
    def stop_weights(self) -> npt.NDArray[np.int64]:
        """Weight collected at each stop in units, shape (number of stops,)."""
        return np.array(
            [sum(int(self.weights[v - 1]) for v in nodes) for nodes in self.stops],
            dtype=np.int64,
        )

    def route_length(self, route: Sequence[int]) -> float:
        """Return the length of the way from the depot past the nodes and back, metres."""
        if not len(route):
            return 0.0
        rows = self.place_of_node[[0, *route, 0]]
        return float(self.place_distances[rows[:-1], rows[1:]].sum())

    def length(self, routes: Sequence[Sequence[int]]) -> float:
        """Return the total length of several routes, metres."""
        return float(sum(self.route_length(route) for route in routes))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Facts about the input that its plans depend on, one sentence each."""
        if not isinstance(self.warehouse, DistanceTable):
            return ()  # metric by construction
        found = []
        d = self.place_distances
        first = np.unique(self.place_of_node, return_index=True)[1].tolist()
        names = [self.node_name(node) for node in first]
        if not np.allclose(d, d.T, rtol=0, atol=1e-9):
            i, j = divmod(int(np.argmax(np.abs(d - d.T))), len(d))
            found.append(
                f"the distances are asymmetric: {names[i]} to {names[j]} is {d[i, j]:g}, "
                f"back {d[j, i]:g}"
            )
        if (gap := _triangle_gap(d)) is not None:
            i, k, j = gap
            found.append(
                "the distances violate the triangle inequality: "
                f"{names[i]} to {names[j]} is {d[i, j]:g}, but "
                f"{d[i, k] + d[k, j]:g} over {names[k]}"
            )
        return tuple(found)

    @property
    def size(self) -> int:
        """Number of items."""
        return len(self.items)

    def node_name(self, node: int) -> str:
        """Return ``depot`` or the id of the item at a node."""
        return "depot" if node == 0 else self.items[node - 1].id

    # -- other questions about the same warehouse ------------------------------------

    def split_orders(self) -> Instance:
        """Return the instance in which every item stands alone, as in the paper's formulas."""
        singles = tuple(Order(id=item.id, items=(item.id,)) for item in self.items)
        return dataclasses.replace(self, orders=singles, split=True)

    def with_robots(self, count: int | None) -> Instance:
        """Return the instance with `count` robots like the largest; ``None`` sets no limit."""
        if count is not None and count < 1:
            raise InputError(
                f"{count} robots are too few", field="robots", mend="give 1 or more, or 'free'"
            )
        if count is not None and count > MAX_ITEMS:
            raise InputError(
                f"{count} robots are more than {MAX_ITEMS}", field="robots", mend="give fewer"
            )
        model = max(self.robots, key=lambda r: r.capacity)
        wanted = max(len(self.orders), 1) if count is None else count
        robots = tuple(dataclasses.replace(model, id=f"R{k + 1}", trips=1) for k in range(wanted))
        return dataclasses.replace(self, robots=robots)


def _unique(ids: Sequence[str], what: str) -> None:
    seen: set[str] = set()
    for i, one in enumerate(ids):
        if one in seen:
            raise InputError(
                f"the id {one!r} is used twice",
                field=f"{what}[{i}].id",
                mend="give each an id of its own",
            )
        seen.add(one)


def _some(names: Sequence[str], most: int = 5) -> str:
    shown = ", ".join(names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown


def _triangle_gap(d: npt.NDArray[np.float64]) -> tuple[int, int, int] | None:
    """Return the worst (i, k, j) with d[i,k] + d[k,j] < d[i,j], or None."""
    worst, where = 1e-9 * max(float(d.max(initial=0.0)), 1.0), None
    # Every pivot of a large matrix would take minutes; a few hundred find any common fault.
    for k in range(0, len(d), 1 + len(d) // 400):
        gap = d - (d[:, k, None] + d[None, k, :])
        if (top := float(gap.max())) > worst:
            i, j = divmod(int(gap.argmax()), len(d))
            worst, where = top, (i, k, j)
    return where
