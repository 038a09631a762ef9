"""Whether items, orders and robots make sense together, before any distance is known."""

from __future__ import annotations

from collections.abc import Sequence

from qrobot.errors import InputError
from qrobot.problem.checks import first_invisible
from qrobot.problem.entities import Item, Order, Robot, Stock
from qrobot.problem.times import check_available, check_order_times
from qrobot.problem.warehouse import Place, Warehouse

__all__ = [
    "MAX_ITEMS",
    "MAX_POOL",
    "MAX_STOPS",
    "check_entities",
    "check_robots",
    "check_stock",
    "refusal_of_pool",
    "some",
]

MAX_ITEMS = 20_000
"""More items than this are refused: plan them in waves."""

MAX_POOL = 200_000
"""More items than this are no pool that waves are cut from."""

MAX_STOPS = 2_500
"""More stops (places of each order) than this are refused: their distance matrix alone takes
50 MB, and every solver keeps a few of its size (a Pi 4 may have 2 GB)."""


ADVICE = "plan them in waves (qrobot waves)"
"""What whoever asks for more than one plan should do."""


MIN_SPEED, MAX_SPEED = 1e-6, 1e6
"""Metres a second, bounded as lengths are, so that no driving time overflows."""


MAX_PICK = 1e6
"""Seconds to collect one item."""


MAX_LEVEL = 1_000
"""Shelves above each other."""


def check_entities(
    warehouse: Warehouse,
    items: Sequence[Item],
    orders: Sequence[Order],
    robots: Sequence[Robot],
    *,
    pool: bool = False,
) -> None:
    """Refuse ids that repeat or dangle, numbers out of range, places outside, and too much.

    A `pool` may have more items, and any number of stops.
    """
    most = MAX_POOL if pool else MAX_ITEMS
    if len(items) > most:
        raise InputError(
            f"{len(items)} items are more than the {most} that one "
            f"{'pool' if pool else 'plan'} may have",
            field="items",
            advice="give a part of them" if pool else ADVICE,
        )
    _unique([i.id for i in items], "items")
    _unique([o.id for o in orders], "orders")
    _check_items(warehouse, items)
    check_robots(robots)
    check_order_times(orders)
    owner = _owners(items, orders)
    if not pool:
        _check_stops(items, owner)


def _check_items(warehouse: Warehouse, items: Sequence[Item]) -> None:
    for i, item in enumerate(items):
        if item.weight < 0:
            raise InputError(
                f"weight {float(item.weight):g} of item {item.id!r} is negative",
                field=f"items[{i}].weight",
                advice="use zero or more",
            )
        if not 0 <= item.pick_seconds <= MAX_PICK:  # NaN too
            raise InputError(
                f"{item.pick_seconds:g} seconds to collect item {item.id!r} are not 0 to "
                f"{MAX_PICK:g}",
                field=f"items[{i}].pick_seconds",
                advice="use seconds from zero",
            )
        if item.quantity < 1:
            raise InputError(
                f"quantity {item.quantity} of item {item.id!r} is below 1",
                field=f"items[{i}].quantity",
                advice="use a whole number from 1",
            )
        _check_names(item, ("article", "label", "category"), f"items[{i}]")
        _check_level(item, f"items[{i}]")
        if item.volume < 0:
            raise InputError(
                f"volume {float(item.volume):g} of item {item.id!r} is negative",
                field=f"items[{i}].volume",
                advice="use zero or more",
            )
        try:
            warehouse.check(item.place)
        except InputError as error:
            path = f"items[{i}].at" + (f".{error.field}" if error.field else "")
            raise InputError(
                f"{error.problem} (item {item.id!r})", field=path, advice=error.advice
            ) from None


def _check_names(one: Item | Stock, names: Sequence[str], path: str) -> None:
    for name in names:
        if (hidden := first_invisible(getattr(one, name))) is not None:
            raise InputError(
                f"holds the invisible character {hidden}",
                field=f"{path}.{name}",
                advice="remove it",
            )


def _check_level(one: Item | Stock, path: str) -> None:
    if not 0 <= one.level <= MAX_LEVEL:
        raise InputError(
            f"level {one.level} is not 0 to {MAX_LEVEL}",
            field=f"{path}.level",
            advice="count the shelves from the floor",
        )


def check_robots(robots: Sequence[Robot]) -> None:
    """Refuse a fleet without robots, with an id twice, or with a number out of range."""
    _unique([r.id for r in robots], "robots")
    if not robots:
        raise InputError("no robots", field="robots", advice="give at least one robot")
    for i, robot in enumerate(robots):
        if robot.capacity <= 0:
            raise InputError(
                f"capacity {float(robot.capacity):g} of robot {robot.id!r} is not positive",
                field=f"robots[{i}].capacity",
                advice="use a number above zero",
            )
        if not MIN_SPEED <= robot.speed <= MAX_SPEED:  # NaN too
            raise InputError(
                f"speed {robot.speed:g} of robot {robot.id!r} is not {MIN_SPEED:g} to "
                f"{MAX_SPEED:g}",
                field=f"robots[{i}].speed",
                advice="use metres a second above zero",
            )
        check_available(robot.available, robot.id, f"robots[{i}].available")
        if robot.trips < 1:
            raise InputError(
                f"{robot.trips} trips for robot {robot.id!r} are too few",
                field=f"robots[{i}].trips",
                advice="use 1 or more, or remove the robot",
            )


def check_stock(warehouse: Warehouse, items: Sequence[Item], stock: Sequence[Stock]) -> None:
    """Check where articles lie, and that there is enough of them.

    Raises
    ------
    InputError
        When a place is outside the warehouse or given twice for an article, or when items ask
        for more pieces than an article has, or than lie in their place.
    """
    left: dict[tuple[str, Place], int] = {}
    total: dict[str, int] = {}
    for i, one in enumerate(stock):
        _check_names(one, ("label",), f"stock[{i}]")
        _check_level(one, f"stock[{i}]")
        try:
            warehouse.check(one.place)
        except InputError as error:
            path = f"stock[{i}].at" + (f".{error.field}" if error.field else "")
            raise InputError(
                f"{error.problem} (article {one.article!r})", field=path, advice=error.advice
            ) from None
        if not one.article or one.quantity < 1 or (one.article, one.place) in left:
            problem, advice = f"{one.quantity} pieces are too few", "use 1 or more, or remove it"
            if not one.article:
                problem, advice = "an article without a name", "name it as items do"
            elif one.quantity >= 1:
                problem = f"article {one.article!r} is in {one.place} twice"
                advice = "give one quantity"
            raise InputError(problem, field=f"stock[{i}]", advice=advice)
        left[one.article, one.place] = one.quantity
        total[one.article] = total.get(one.article, 0) + one.quantity
    asked: dict[str, int] = {}
    for i, item in enumerate(items):
        if item.article not in total:
            continue
        asked[item.article] = asked.get(item.article, 0) + item.quantity
        there = left.get((item.article, item.place), 0)
        if asked[item.article] > total[item.article]:
            raise InputError(
                f"{asked[item.article]} pieces of article {item.article!r} are asked for, and "
                f"{total[item.article]} are in stock",
                field=f"items[{i}].quantity",
                advice="ask for fewer, or add to the stock",
            )
        if item.quantity > there:
            raise InputError(
                f"{item.quantity} pieces of article {item.article!r} are asked for in {item.place},"
                f" and {there} are left there",
                field=f"items[{i}].at",
                advice="take them from several places of its stock, an item each",
            )
        left[item.article, item.place] = there - item.quantity


def _owners(items: Sequence[Item], orders: Sequence[Order]) -> dict[str, str]:
    """Return the order of every item."""
    known = {item.id for item in items}
    owner: dict[str, str] = {}
    for i, order in enumerate(orders):
        if not order.items:
            raise InputError(
                f"order {order.id!r} is empty",
                field=f"orders[{i}].items",
                advice="name at least one item or remove the order",
            )
        for j, item_id in enumerate(order.items):
            path = f"orders[{i}].items[{j}]"
            if item_id not in known:
                raise InputError(
                    f"order {order.id!r} names the unknown item {item_id!r}",
                    field=path,
                    advice="add the item or correct the name",
                )
            if item_id in owner:
                raise InputError(
                    f"item {item_id!r} is in orders {owner[item_id]!r} and {order.id!r}",
                    field=path,
                    advice="keep it in one order; give a second piece an id of its own",
                )
            owner[item_id] = order.id
    if len(owner) < len(known):
        missing = sorted(known - set(owner))
        raise InputError(
            f"items {some(missing)} are in no order",
            field="orders",
            advice="put every item into an order, or leave the orders out",
        )
    return owner


def _check_stops(items: Sequence[Item], owner: dict[str, str]) -> None:
    place = {item.id: item.place for item in items}
    stops = len({(owner[item_id], place[item_id]) for item_id in owner})
    if stops > MAX_STOPS:
        raise InputError(
            f"{stops} stops (places of each order) are more than the {MAX_STOPS} that one plan "
            f"may have: their distances alone would take {8 * (stops + 1) ** 2 / 1e6:.0f} MB",
            field="orders",
            advice=ADVICE,
        )


def refusal_of_pool(orders: Sequence[Order]) -> InputError:
    """Return the error of whoever wants distances of a pool."""
    return InputError(
        f"{len(orders)} orders were read as a pool, which has no distances",
        field="orders",
        advice=ADVICE,
    )


def _unique(ids: Sequence[str], what: str) -> None:
    seen: set[str] = set()
    for i, one in enumerate(ids):
        if not one or (hidden := first_invisible(one)) is not None:
            raise InputError(
                "is empty" if not one else f"holds the invisible character {hidden}",
                field=f"{what}[{i}].id",
                advice="give a name" if not one else "remove it",
            )
        if one in seen:
            raise InputError(
                f"the id {one!r} is used twice",
                field=f"{what}[{i}].id",
                advice="give each an id of its own",
            )
        seen.add(one)


def some(names: Sequence[str], most: int = 5) -> str:
    """Return the first few names, and how many more there are."""
    shown = ", ".join(names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown
