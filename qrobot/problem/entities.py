"""What is collected and who collects: items, orders, robots."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from qrobot.problem.units import exact
from qrobot.problem.warehouse import Place

__all__ = ["Item", "Order", "Robot"]


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
