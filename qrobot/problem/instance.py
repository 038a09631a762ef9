"""The question: which robot collects which orders from where.

Everything here is frozen and checked when it is made. The numbers that solvers need
(distances, integer weights) are derived once, on first use.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qrobot._notebook import html_table, shown_name
from qrobot.errors import InputError
from qrobot.problem.checks import check_reference
from qrobot.problem.entities import Item, Order, Robot, Stock
from qrobot.problem.fleets import fleet_of_size
from qrobot.problem.table import unreachable
from qrobot.problem.times import Times
from qrobot.problem.units import MAX_UNITS, common_unit, in_units
from qrobot.problem.useful import first_trips, outlying, useful_limit
from qrobot.problem.validity import check_entities, check_stock, refusal_of_pool, some
from qrobot.problem.warehouse import Place, Warehouse

__all__ = ["ELSEWHERE", "Instance"]

MARKED = 10.0
"""Ways this many times longer than any useful one mark something; models take them for less."""


ELSEWHERE = "articles lie in several places: items are taken from their own, others are not tried"


@dataclass(frozen=True, repr=False)
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
        A known value of the least distance, from a benchmark file; never part of the
        question.
    remarks
        What the reader of a file passed over or took for granted, one sentence each.
    stock
        Articles that lie in several places, and how many pieces in each: an item of such an
        article may be taken from any of them. Its own place is a first choice, which the stock
        has enough pieces for.
    times
        Seconds beside driving that are the same for all robots.
    pool
        Whether it may be larger than one plan: it has no distances, waves are cut from it.

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
    remarks: tuple[str, ...] = field(default=(), compare=False)
    stock: tuple[Stock, ...] = ()
    times: Times = field(default=Times())
    pool: bool = False

    def __post_init__(self) -> None:
        """Check everything that can be checked without distances."""
        check_entities(self.warehouse, self.items, self.orders, self.robots, pool=self.pool)
        check_stock(self.warehouse, self.items, self.stock)
        if self.reference is not None:
            check_reference(self.reference)

    def __repr__(self) -> str:
        return (
            f"<Instance {shown_name(self.name)}: {len(self.items)} items, "
            f"{len(self.orders)} orders, {len(self.robots)} robots>"
        )

    def _repr_html_(self) -> str:
        """Return a table of the fleet for notebooks."""
        fleet = Counter((float(robot.capacity), robot.trips) for robot in self.robots)
        heads = ("robots", "capacity", "trips of each")
        rows = [(number, f"{room:g}", trips) for (room, trips), number in fleet.items()]
        return html_table(f"{repr(self)[1:-1]} in {self.warehouse.kind}", heads, rows)

    # -- numbers for solvers ---------------------------------------------------------

    @cached_property
    def distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (node 0) and items (node i + 1), shape (n + 1, n + 1).

        All finite, for models: no way costs more than `MARKED` times `longest_useful`, be it
        forbidden or marked by a large number. All others are as they are, so that the energy
        of a plan is its distance.

        Raises
        ------
        InputError
            When an item cannot be reached from the depot or left again.
        """
        return self._priced(self.place_of_node, MARKED)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """The different places that items lie in, in the sequence of the items."""
        return tuple(dict.fromkeys(item.place for item in self.items))

    @cached_property
    def demand(self) -> dict[str, int]:
        """Pieces that all orders together ask of each article that has a stock."""
        known = {one.article for one in self.stock}
        asked = Counter[str]()
        for item in self.items:
            if item.article in known:
                asked[item.article] += item.quantity
        return dict(asked)

    @cached_property
    def place_of_node(self) -> npt.NDArray[np.intp]:
        """For each node its row in `place_distances`, shape (n + 1,)."""
        rows = self.row_of_place
        return np.array([0, *(rows[item.place] for item in self.items)], dtype=np.intp)

    @cached_property
    def row_of_place(self) -> dict[Place, int]:
        """For each place its row in `place_distances`; the depot's is 0."""
        return {place: i + 1 for i, place in enumerate(self.places)}

    @cached_property
    def place_distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (row 0) and the different places: small however many items.

        ``inf`` where no way leads directly.

        Raises
        ------
        InputError
            When an item cannot be reached from the depot or left again; of a pool.
        """
        if self.pool:
            raise refusal_of_pool(self.orders)
        matrix = np.ascontiguousarray(self.warehouse.distance_matrix(self.places))
        matrix.flags.writeable = False
        cut_off = unreachable(np.isfinite(matrix))
        if cut_off.size:
            found = np.flatnonzero(np.isin(self.place_of_node, cut_off)) - 1
            way_out = self.warehouse.way_out
            raise InputError(
                f"no way leads from the depot to items {some([self.items[i].id for i in found])} "
                "and back",
                field=f"items[{found[0]}].at",
                advice="move the items" + (f", or {way_out}" if way_out else ""),
            )
        return matrix

    @cached_property
    def longest_useful(self) -> float:
        """What a way costs at most in `stop_distances`; ``inf`` when all stand as they are.

        More than some plan without a forbidden way is long, times the ratio of the robots' speeds,
        so that no plan of least distance or time takes a way of that price: neither one that is
        forbidden nor one that a large number marks.
        """
        if not self.warehouse.has_given_distances or not self.stops:
            return math.inf  # the way there and back is longer than any way of a metric
        rows = self._stop_rows
        speeds = [robot.speed for robot in self.robots]
        return useful_limit(
            self.place_distances[np.ix_(rows, rows)],
            self._order_stops,
            self.order_weights.tolist(),
            self.vehicle_capacities,
            max(speeds) / min(speeds),
        )

    def _priced(self, rows: npt.NDArray[np.intp], times: float) -> npt.NDArray[np.float64]:
        """Return the distances between places, none above so many `longest_useful`."""
        matrix = self.place_distances[np.ix_(rows, rows)]
        if not math.isinf(self.longest_useful):
            np.minimum(matrix, times * self.longest_useful, out=matrix)
        matrix.flags.writeable = False
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
        """Nodes of each stop: items of one order in one place are collected at one stop.

        Only where no way is shorter over a third place: otherwise passing a place twice can
        pay, and every item is a stop of its own.
        """
        found: dict[tuple[int, Place | int], list[int]] = {}
        for o, nodes in enumerate(self.order_nodes):
            for node in nodes:
                place = self.items[node - 1].place if self.warehouse.is_metric else node
                found.setdefault((o, place), []).append(node)
        return tuple(tuple(nodes) for nodes in found.values())

    @cached_property
    def stop_distances(self) -> npt.NDArray[np.float64]:
        """Distances between depot (row 0) and stops, shape (number of stops + 1,) twice.

        All finite, for planners and bounds: no way costs more than `longest_useful`, which
        changes no shortest plan.
        """
        return self._priced(self._stop_rows, 1.0)

    @cached_property
    def _stop_rows(self) -> npt.NDArray[np.intp]:
        """For each stop its row in `place_distances`, the depot first."""
        return self.place_of_node[[0, *(nodes[0] for nodes in self.stops)]]

    @cached_property
    def _order_stops(self) -> list[list[int]]:
        """For each order its rows in `stop_distances`."""
        found: list[list[int]] = [[] for _ in self.orders]
        for s, nodes in enumerate(self.stops):
            found[int(self.order_of_node[nodes[0]])].append(s + 1)
        return found

    @cached_property
    def stop_weights(self) -> npt.NDArray[np.int64]:
        """Weight collected at each stop in units, shape (number of stops,)."""
        return np.array(
            [sum(int(self.weights[v - 1]) for v in nodes) for nodes in self.stops],
            dtype=np.int64,
        )

    @cached_property
    def _first_routes(self) -> list[list[int]] | None:
        lots, weights = self._order_stops, self.order_weights.tolist()
        found = first_trips(self.stop_distances, lots, weights, self.vehicle_capacities)
        if found is None:
            return None
        return [[node for s in trip for node in self.stops[s - 1]] for trip in found]

    def first_routes(self) -> list[list[int]] | None:
        """Return the nodes of each trip of a plan made in no time, or None where it fails."""
        return None if self._first_routes is None else [list(trip) for trip in self._first_routes]

    def route_length(self, route: Sequence[int]) -> float:
        """Return the length of the way from the depot past the nodes and back, metres.

        ``inf`` when it takes a forbidden way.
        """
        if not len(route):
            return 0.0
        rows = self.place_of_node[[0, *route, 0]]
        return float(self.place_distances[rows[:-1], rows[1:]].sum())

    @cached_property
    def has_deadlines(self) -> bool:
        """Whether some order must be back at a time."""
        return any(math.isfinite(order.deadline) for order in self.orders)

    @property
    def routing(self) -> str:
        """How trips are walked: ``exact`` for shortest tours, otherwise the name of a policy."""
        return "exact"

    def in_sequence(self, routes: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return the nodes of each trip in the sequence in which they are walked."""
        return [list(route) for route in routes]

    def length(self, routes: Sequence[Sequence[int]]) -> float:
        """Return the total length of several routes, metres."""
        return float(sum(self.route_length(route) for route in routes))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Facts about the input that its plans depend on, one sentence each."""
        if not self.items:
            return self.remarks
        elsewhere = (ELSEWHERE,) if self.stock else ()
        d = self.place_distances
        first = np.unique(self.place_of_node, return_index=True)[1].tolist()
        names = [self.node_name(node) for node in first]
        return (
            self.remarks
            + elsewhere
            + outlying(d, names, self.longest_useful)
            + self.warehouse.notes(d, self.places, names)
        )

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
        owner = {item: order for order in self.orders for item in order.items}
        singles = tuple(
            dataclasses.replace(owner[item.id], id=item.id, items=(item.id,)) for item in self.items
        )
        return dataclasses.replace(self, orders=singles, split=True)

    def with_robots(self, count: int | None) -> Instance:
        """Return the instance with another number of robots.

        Parameters
        ----------
        count
            Fewer than there are: the first of them. More: further ones like them, if all are
            alike. ``None``: no limit, which means one trip of the largest for each order.

        Raises
        ------
        InputError
            When the count is out of range, or more than there are of an unlike fleet.
        """
        return dataclasses.replace(self, robots=fleet_of_size(self.robots, count, len(self.orders)))
