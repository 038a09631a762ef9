"""What became of a pool: its waves with their plans, and what cutting it cost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from qrobot._json import json_text
from qrobot._numbers import number
from qrobot._text import columns, count
from qrobot.plan import Plan
from qrobot.plan.clock import Measures
from qrobot.problem import Instance

__all__ = ["WAVES_SCHEMA", "Comparison", "Wave", "Waves"]

WAVES_SCHEMA = "qrobot.waves/1"

HEADS = (
    "wave", "begins", "ends", "orders", "late", "items", "stops", "trips", "distance", "bound",
    "ended",
)  # fmt: skip


TOLERANCE = 1e-6
"""Seconds that nobody is late by."""


@dataclass(frozen=True, slots=True)
class Wave:
    """Orders that are planned together, and their plan.

    Parameters
    ----------
    number
        From 1.
    instance, plan
        The question and the answer; the checker has accepted the plan.
    measures
        What the plan comes to by every measure, in seconds from the wave's beginning.
    begins
        When the last robot is back from the waves before, seconds.
    bound
        A valid lower bound of the cost of any plan of this wave.
    is_optimal
        Whether no plan of it costs less.
    ended
        Why its search ended, as `Result.ended` tells.
    seconds
        How long the search took.
    """

    number: int
    instance: Instance
    plan: Plan
    measures: Measures
    begins: float
    bound: float
    is_optimal: bool
    ended: str
    seconds: float

    @property
    def ends(self) -> float:
        """When its last robot is back, seconds."""
        return self.begins + self.measures.makespan

    @property
    def stops(self) -> int:
        """Number of stops: places of each order."""
        instance = self.instance
        place = {item.id: item.place for item in instance.items}
        return sum(len({place[i] for i in order.items}) for order in instance.orders)


@dataclass(frozen=True, slots=True)
class Comparison:
    """The orders of several waves in one plan, made with as much time or work as theirs.

    Parameters
    ----------
    waves
        Their numbers.
    apart, together
        What the plans of the waves cost, and the one plan.
    bound
        A valid lower bound of the cost of any plan of them together.
    """

    waves: tuple[int, ...]
    apart: float
    together: float
    bound: float

    @property
    def price(self) -> float | None:
        """By which share the waves cost more than the one plan; below zero: less."""
        return self.apart / self.together - 1 if self.together else None

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "waves": list(self.waves),
            "apart": self.apart,
            "together": self.together,
            "bound": self.bound,
            "price": self.price,
        }

    def to_text(self) -> str:
        """Return it in a sentence."""
        numbers = self.waves
        which = (
            f"waves {numbers[0]} and {numbers[1]}"
            if len(numbers) == 2
            else f"waves 1 to {len(numbers)}"
        )
        price = self.price or 0.0
        return (
            f"{which} in one plan, with as much time: {number(self.together)} (no plan is below "
            f"{number(self.bound)}); apart they cost {number(self.apart)}, {abs(price):.1%} "
            f"{'less' if price < 0 else 'more'}"
        )


@dataclass(frozen=True, slots=True)
class Waves:
    """The waves of a pool, and what is known about the price of cutting it.

    Parameters
    ----------
    pool
        All orders.
    asked
        How it was cut and planned, by the names of the arguments of `plan_waves`.
    waves
        Those that have a plan, in sequence.
    expected
        How many waves there are.
    bound
        A valid lower bound of the cost of any plan of the whole pool, cut or not, in as many
        trips as wanted; zero where none is known.
    compared
        Waves planned together, for comparison.
    notes
        What the reader must know.
    """

    pool: Instance
    asked: dict[str, Any]
    waves: tuple[Wave, ...]
    expected: int
    bound: float
    compared: tuple[Comparison, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def is_complete(self) -> bool:
        """Whether every wave has a plan whose search was not interrupted."""
        planned = [wave for wave in self.waves if wave.ended != "interrupted"]
        return len(planned) == self.expected

    @property
    def cost(self) -> float:
        """What all plans cost together."""
        return math.fsum(wave.plan.cost for wave in self.waves)

    @property
    def distance(self) -> float:
        """How long all trips are together, metres."""
        return math.fsum(wave.plan.distance for wave in self.waves)

    @property
    def gap(self) -> float | None:
        """By which share at most the waves cost more than the best plan of the pool.

        None while waves are missing, or where no bound is known.
        """
        if not self.is_complete or self.bound <= 0:
            return None
        return max(0.0, self.cost / self.bound - 1)

    def late(self, wave: Wave) -> dict[str, float]:
        """Return for each order of a wave that is back after its due time by how much, seconds.

        Measured from the beginning of the first wave, as the pool's due times are.
        """
        due = {order.id: order.due for order in self.pool.orders}
        late = {name: wave.begins + back - due[name] for name, back in wave.measures.back.items()}
        return {name: seconds for name, seconds in late.items() if seconds > TOLERANCE}

    def to_dict(self) -> dict[str, Any]:
        """Return the summary as plain data (schema ``qrobot.waves/1``)."""
        return {
            "schema": WAVES_SCHEMA,
            "pool": self.pool.name,
            "asked": self.asked,
            "orders": len(self.pool.orders),
            "items": self.pool.size,
            "expected": self.expected,
            "complete": self.is_complete,
            "cost": self.cost,
            "distance": self.distance,
            "bound": self.bound,
            "gap": self.gap,
            "waves": [_wave_data(wave, self.late(wave)) for wave in self.waves],
            "compared": [one.to_dict() for one in self.compared],
            "notes": list(self.notes),
        }

    def to_json(self) -> str:
        """Return the summary as JSON text."""
        return json_text(self.to_dict(), indent=1, ensure_ascii=False) + "\n"

    def to_text(self) -> str:
        """Return a table of the waves, and what they cost."""
        rows = [
            (
                str(wave.number),
                f"{wave.begins:.0f} s",
                f"{wave.ends:.0f} s",
                str(len(wave.instance.orders)),
                str(len(self.late(wave))),
                str(wave.instance.size),
                str(wave.stops),
                str(len(wave.plan.trips)),
                number(wave.plan.distance),
                number(wave.bound),
                wave.ended,
            )
            for wave in self.waves
        ]
        table = columns(HEADS, rows, numbers=frozenset(range(len(HEADS) - 1)))
        return "\n".join([table.rstrip("\n"), *self._sentences()]) + "\n"

    def _sentences(self) -> list[str]:
        objective = self.asked["objective"]
        orders, waves = count(len(self.pool.orders), "order"), count(self.expected, "wave")
        lines = [f"{self.pool.name}: {orders} in {waves}, {objective} {number(self.cost)}"]
        if not self.is_complete:
            done = sum(wave.ended != "interrupted" for wave in self.waves)
            lines.append(f"{done} of {waves} are finished; go on with --resume")
        if self.gap is not None:
            above = math.ceil(self.gap * 1e3) / 1e3  # rounded up: it must stay true
            lines.append(
                f"no plan of the whole pool is below {number(self.bound)}: cutting it, and "
                f"searches without a proof, cost at most {above:.1%}"
            )
        lines += [one.to_text() for one in self.compared]
        return lines + [f"note: {note}" for note in self.notes]


def _wave_data(wave: Wave, late: dict[str, float]) -> dict[str, Any]:
    return {
        "wave": wave.number,
        "begins": wave.begins,
        "ends": wave.ends,
        "late": late,
        "orders": [order.id for order in wave.instance.orders],
        "items": wave.instance.size,
        "stops": wave.stops,
        "trips": len(wave.plan.trips),
        "cost": wave.plan.cost,
        "distance": wave.plan.distance,
        "bound": wave.bound,
        "is_optimal": wave.is_optimal,
        "ended": wave.ended,
        "seconds": wave.seconds,
    }
