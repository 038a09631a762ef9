"""What a plan takes from which place, where articles lie in several."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

from qrobot.problem.entities import Item, Order, Stock, picked
from qrobot.problem.instance import Instance
from qrobot.problem.warehouse import Node, Place, Point, Slot

__all__ = ["Pick", "as_picked", "picks_of"]


@dataclass(frozen=True, slots=True)
class Pick:
    """Pieces of an article for an order, taken from one place of the stock.

    Parameters
    ----------
    id
        As the stops of trips name it.
    order
        Id of the order.
    article
        Name of the article.
    place
        Where the pieces are taken from.
    quantity
        How many.
    """

    id: str
    order: str
    article: str
    place: Place
    quantity: int

    def to_dict(self) -> dict[str, Any]:
        """Return the pick as plain data."""
        place = self.place
        at = {"node": place.index} if isinstance(place, Node) else dataclasses.asdict(place)
        return {
            "id": self.id,
            "order": self.order,
            "article": self.article,
            "at": at,
            "quantity": self.quantity,
        }

    @classmethod
    def from_dict(cls, data: Any) -> Pick:
        """Read a pick from plain data.

        Raises
        ------
        TypeError
            When something is missing, unknown, or of another type.
        """
        names = ("id", "order", "article")
        if not isinstance(data, dict) or not all(isinstance(data.get(n), str) for n in names):
            raise TypeError("a pick needs id, order and article as text")
        at, pieces = data.get("at"), data.get("quantity")
        if not isinstance(at, dict):
            raise TypeError("a pick needs a place")
        if not isinstance(pieces, int) or isinstance(pieces, bool) or pieces < 1:
            raise TypeError(f"{pieces!r:.40} is not a number of pieces")
        place: Place
        if "node" in at:
            place = Node(at["node"])
        elif "x" in at:
            place = Point(float(at["x"]), float(at["y"]))
        else:
            place = Slot(**at)
        return cls(data["id"], data["order"], data["article"], place, pieces)


def picks_of(instance: Instance) -> tuple[Pick, ...]:
    """Return the picks of an instance's own items, those with a stock."""
    items = {item.id: item for item in instance.items}
    return tuple(
        Pick(name, order.id, items[name].article, items[name].place, items[name].quantity)
        for order in instance.orders
        for name in order.items
        if items[name].article in instance.demand
    )


def as_picked(instance: Instance, picks: tuple[Pick, ...], *, with_stock: bool = True) -> Instance:
    """Return the instance with the items that a plan's picks make of the stock, if it has one.

    Weights and times are shares of what the order asks of the article.

    Parameters
    ----------
    instance, picks
        The question, and what the plan takes.
    with_stock
        Whether the stock stays; it must then have enough in every place.

    Raises
    ------
    InputError
        When an item cannot be as a pick says.
    """
    if not picks or not instance.stock:
        return instance
    stock = {one.article for one in instance.stock}
    bins = {(one.article, one.place): one for one in instance.stock}
    items = {item.id: item for item in instance.items}
    taken: defaultdict[str, list[Pick]] = defaultdict(list)
    for pick in picks:
        taken[pick.order].append(pick)
    made: list[Item] = []
    orders: list[Order] = []
    for order in instance.orders:
        first = len(made)
        groups: defaultdict[str, list[Item]] = defaultdict(list)
        for name in order.items:
            if items[name].article in stock:
                groups[items[name].article].append(items[name])
            else:
                made.append(items[name])
        for pick in taken[order.id]:
            group = groups.get(pick.article, [])
            source = bins.get((pick.article, pick.place))
            nowhere = Stock(pick.article, pick.place, 0)  # which the checker tells
            made.append(picked(group, pick.id, source or nowhere, pick.quantity))
        orders.append(dataclasses.replace(order, items=tuple(item.id for item in made[first:])))
    left = instance.stock if with_stock else ()
    return dataclasses.replace(instance, items=tuple(made), orders=tuple(orders), stock=left)
