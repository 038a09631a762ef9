"""What came of trips that each robot planned by itself, beside the central plan."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from qrobot._numbers import number
from qrobot._text import count

if TYPE_CHECKING:
    from qrobot.planning.result import SamplerReport

__all__ = ["EachRobot", "OwnTrip"]


@dataclass(frozen=True, slots=True)
class OwnTrip:
    """One trip of the central plan, and the sequence that its robot found for it.

    Parameters
    ----------
    trip
        Its number in the plan, from 1.
    robot
        Id of the robot.
    stops
        How many places are in the sequence.
    central, own
        Its length in the central plan, and as it is walked now, metres.
    sampler
        What a sampler found by itself, before repair and polish; ``None`` for planners.
    kept
        Why the central sequence stays; empty when the robot has its own.
    """

    trip: int
    robot: str
    stops: int
    central: float
    own: float
    sampler: SamplerReport | None = None
    kept: str = ""

    def to_text(self) -> str:
        """Return it in a line."""
        line = f"trip {self.trip} of {self.robot}, {count(self.stops, 'stop')}: "
        line += f"central {number(self.central)}, "
        if self.kept:
            return f"{line}kept: {self.kept}"
        line += f"own {number(self.own)}"
        if (s := self.sampler) is None:
            return line
        if s.best is None:
            return f"{line} (no read of {s.backend} is a plan; repair and polish found it)"
        added = s.best - self.own
        rest = f", repair and polish made it {number(added)} shorter" if added > 1e-9 else ""
        return f"{line} ({s.backend} by itself {number(s.best)}, {s.variables} variables{rest})"


@dataclass(frozen=True, slots=True)
class EachRobot:
    """Trips whose orders a central plan chose and whose sequences the robots planned.

    Parameters
    ----------
    backend
        Who planned each sequence.
    central, cost
        What the central plan costs, and the plan of the robots' own sequences.
    trips
        In the plan's sequence.
    """

    backend: str
    central: float
    cost: float
    trips: tuple[OwnTrip, ...]

    @property
    def price(self) -> float | None:
        """By which share the own sequences cost more than the central ones; below zero: less."""
        return self.cost / self.central - 1 if self.central else None

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {**asdict(self), "trips": list(map(asdict, self.trips)), "price": self.price}

    def to_text(self) -> str:
        """Return it in a few plain lines."""
        price, kept = self.price or 0.0, sum(bool(one.kept) for one in self.trips)
        more = "less" if price < 0 else "more"
        head = (
            f"each robot's own sequences by {self.backend}: {number(self.cost)}, the central plan "
            f"{number(self.central)}: decentralising costs {abs(price):.2%} {more}"
        )
        if kept:
            head += f" ({kept} of {count(len(self.trips), 'trip')} kept the central sequence)"
        return "\n".join([head, *(f"  {one.to_text()}" for one in self.trips)])
