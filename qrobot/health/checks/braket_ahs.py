"""Braket's analog simulator: a Rabi flop, and the blockade that lets one of two atoms through.

Pulses are chosen so that (nearly) every shot must end the same way.
"""

from __future__ import annotations

import math
from typing import Any

from qrobot.health.check import Check

SHOTS, STEPS = 200, 60
PEAK = 5e6
"""Rabi frequency in rad/s."""

RAMP = 1e-7
"""Seconds that the pulse takes to rise, and to fall."""

APART = 4.5e-6
"""Metres between the atoms: their shift of 650e6 rad/s is 130 times the Rabi frequency."""


def program(atoms: int, area: float) -> Any:
    """Return a resonant pulse of this area (rad) on a row of atoms."""
    from braket.ahs import AnalogHamiltonianSimulation, AtomArrangement, DrivingField
    from braket.timings import TimeSeries

    row = AtomArrangement()
    for k in range(atoms):
        row.add([0.0, k * APART])
    top = area / PEAK - RAMP  # the ramps add half a ramp each
    times = (0.0, RAMP, RAMP + top, 2 * RAMP + top)

    def series(*values: float) -> Any:
        made = TimeSeries()
        for time, value in zip(times, values, strict=True):
            made.put(time, value)
        return made

    still = series(0.0, 0.0, 0.0, 0.0)
    drive = DrivingField(amplitude=series(0.0, PEAK, PEAK, 0.0), phase=still, detuning=still)
    return AnalogHamiltonianSimulation(register=row, hamiltonian=drive)


def answer() -> list[float]:
    """Return the parts of the shots: one atom up; of two, exactly one up; of two, none up."""
    import numpy as np
    from braket.devices import LocalSimulator

    device = LocalSimulator("braket_ahs")
    np.random.seed(1)  # noqa: NPY002 the simulator draws from the global generator

    def part(atoms: int, area: float, up: int) -> float:
        found = device.run(program(atoms, area), shots=SHOTS, steps=STEPS).result()
        # An atom that is not seen afterwards (0) was in the Rydberg state, which the trap repels.
        shots = [shot.post_sequence for shot in found.measurements]
        return sum(int(np.sum(shot == 0)) == up for shot in shots) / SHOTS

    return [
        part(1, math.pi, 1),
        part(2, math.pi / math.sqrt(2), 1),
        part(2, 2 * math.pi / math.sqrt(2), 0),
    ]


def expected() -> list[float]:
    """Return certainty: an area of pi flops, and two atoms behave as one, sqrt(2) times faster."""
    return [1.0, 1.0, 1.0]


CHECK = Check(
    module=__name__,
    title="a Rabi flop and a blockade",
    group="gate model",
    imports=("braket.ahs", "braket.devices", "braket.timings"),
    distributions=("amazon-braket-sdk", "amazon-braket-default-simulator"),
    answer=answer,
    expected=expected,
    source="closed form; what leaks past the blockade is below 1e-3",
    tolerance=0.01,  # two shots, of which a leak of 1e-3 takes one in five runs
    extra="braket",
)
