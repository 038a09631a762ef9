"""Braket's analog simulator: a Rabi flop, and the blockade that lets one of two atoms through.

Three pulses must end (nearly) every shot the same way; such a blockade hardly asks how strong it
is. So a fourth one drives two atoms at its edge, where every part depends on the shift.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qrobot.health.check import Check

SHOTS, STEPS = 200, 60
PEAK = 5e6
"""Rabi frequency in rad/s."""

RAMP = 1e-7
"""Seconds that the pulse takes to rise, and to fall."""

APART = 4.5e-6
"""Metres between the atoms: their shift of 650e6 rad/s is 130 times the Rabi frequency."""

EDGE, MANY = 9e-6, 2000
"""Metres where the shift of 10e6 rad/s is only twice that, and the shots there."""

SCATTER = 0.3
"""Weight of the parts at the edge: of 2000 shots they scatter by 0.01, a tenth more shift moves
them by 0.085, and a check has one tolerance."""

C6 = 5.42e-24
"""Of the atoms' interaction in rad m**6 / s, published for Aquila (QuEra 2023, arXiv 2306.11727).
"""


def program(atoms: int, area: float, apart: float = APART) -> Any:
    """Return a resonant pulse of this area (rad) on a row of atoms, so many metres apart."""
    from braket.ahs import AnalogHamiltonianSimulation, AtomArrangement, DrivingField
    from braket.timings import TimeSeries

    row = AtomArrangement()
    for k in range(atoms):
        row.add([0.0, k * apart])
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
    """Return the parts of the shots: one atom up; of two, exactly one up; of two, none up.

    And of two at the edge: none, one and both up.
    """
    from braket.devices import LocalSimulator

    device = LocalSimulator("braket_ahs")
    np.random.seed(1)  # noqa: NPY002 the simulator draws from the global generator

    def parts(atoms: int, area: float, apart: float, shots: int) -> Any:
        found = device.run(program(atoms, area, apart), shots=shots, steps=STEPS).result()
        # An atom that is not seen afterwards (0) was in the Rydberg state, which the trap repels.
        up = [int(np.sum(shot.post_sequence == 0)) for shot in found.measurements]
        return np.bincount(up, minlength=3) / shots

    return [
        float(parts(1, math.pi, APART, SHOTS)[1]),
        float(parts(2, math.pi / math.sqrt(2), APART, SHOTS)[1]),
        float(parts(2, 2 * math.pi / math.sqrt(2), APART, SHOTS)[0]),
        *(SCATTER * parts(2, 2 * math.pi, EDGE, MANY)).tolist(),
    ]


def expected() -> list[float]:
    """Return certainty: an area of pi flops, and two atoms behave as one, sqrt(2) times faster.

    At the edge, what Schroedinger's equation says.
    """
    return [1.0, 1.0, 1.0, *(SCATTER * pair(2 * math.pi, EDGE)).tolist()]


def pair(area: float, apart: float) -> NDArray[np.float64]:
    """Return the chances that none, one and two of two atoms are up, from 4 x 4 matrices."""
    turn, up, still = np.array([[0, 1], [1, 0]]), np.diag([0, 1]), np.eye(2)
    drive = (np.kron(turn, still) + np.kron(still, turn)) / 2
    shift = C6 / apart**6 * np.kron(up, up)
    rise = [(PEAK * (k + 0.5) / STEPS, RAMP / STEPS) for k in range(STEPS)]
    state = np.array([1, 0, 0, 0], dtype=complex)
    for strength, seconds in [*rise, (PEAK, area / PEAK - RAMP), *reversed(rise)]:
        values, vectors = np.linalg.eigh(strength * drive + shift)
        state = vectors @ (np.exp(-1j * values * seconds) * (vectors.T @ state))
    chances = np.abs(state) ** 2
    return np.array([chances[0], chances[1] + chances[2], chances[3]])


CHECK = Check(
    __name__,
    title="a Rabi flop and a blockade",
    group="gate model",
    imports=("braket.ahs", "braket.devices", "braket.timings"),
    distributions=("amazon-braket-sdk", "amazon-braket-default-simulator"),
    source="closed form, of which below 1e-3 leaks; the Schroedinger equation of 4 states in numpy",
    tolerance=0.0125,  # two shots of 200; four standard deviations at the edge
    extra="braket",
)
