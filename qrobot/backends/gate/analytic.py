"""Angles without simulating a state: the best single layer in closed form, and a ramp of several.

A. Ozaeta, W. van Dam and P. L. McMahon, "Expectation values from the single-layer quantum
approximate optimization algorithm on Ising problems", Quantum Science and Technology 7 (2022)
045036. No state is simulated, so the search costs milliseconds at 24 qubits and well under a
second a gamma at 200.
"""

from __future__ import annotations

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.form import Form

__all__ = ["best_layer", "expectation", "ramp", "waves"]


def waves(form: Form, gamma: float) -> tuple[float, float, float]:
    """Return a, b and c with <D> = mean + a sin 2 beta + b sin 4 beta + c sin^2 2 beta.

    Parameters
    ----------
    form
        The cost D.
    gamma
        Angle of the phase exp(-i gamma D).
    """
    h, J, _ = form.ising
    n = form.qubits
    turn = 2 * gamma
    row = np.prod(np.cos(turn * J), axis=1) if n else np.empty(0)  # J[i, i] is 0, its cosine 1
    a = float((h * np.sin(turn * h) * row).sum())
    b = c = 0.0
    for i in range(n - 1):
        js = i + 1 + np.flatnonzero(J[i, i + 1 :])
        if not js.size:
            continue
        couple = J[i, js]
        # Products over all k but i and j: entry i of a row is 1, entry j is set to 1.
        mine = np.cos(turn * np.broadcast_to(J[i], (js.size, n)))
        mine[np.arange(js.size), js] = 1.0
        theirs = np.cos(turn * J[js])
        theirs[:, i] = 1.0
        plus, minus = np.cos(turn * (J[i] + J[js])), np.cos(turn * (J[i] - J[js]))
        for one in (plus, minus):
            one[:, i] = 1.0
            one[np.arange(js.size), js] = 1.0
        single = np.cos(turn * h[i]) * mine.prod(1) + np.cos(turn * h[js]) * theirs.prod(1)
        b += float((couple * np.sin(turn * couple) * single).sum()) / 2
        double = np.cos(turn * (h[i] + h[js])) * plus.prod(1)
        double -= np.cos(turn * (h[i] - h[js])) * minus.prod(1)
        c -= float((couple * double).sum()) / 2
    return a, b, c


def expectation(form: Form, gamma: float, beta: float) -> float:
    """Return the expectation of the cost after one layer, without simulating it."""
    a, b, c = waves(form, gamma)
    two = 2 * beta
    value = form.mean + a * np.sin(two) + b * np.sin(2 * two) + c * np.sin(two) ** 2
    return float(value)


def best_layer(
    form: Form, *, points: int = 60, angles: int = 181, widest: float = 3.0
) -> tuple[float, float, float]:
    """Return gamma, beta and the expectation of the best layer on a grid, refined once.

    Parameters
    ----------
    form
        The cost.
    points
        Gammas in one sweep, up to `widest` divided by the spread of the cost.
    angles
        Betas in one sweep, over all of them.
    widest
        Largest gamma times spread.
    """
    if not form.qubits or form.spread == 0.0:
        return 0.0, 0.0, form.mean
    unit = widest / form.spread
    gammas = unit * np.arange(1, points + 1) / points
    betas = np.linspace(-np.pi / 2, np.pi / 2, angles)
    found = (np.inf, 0.0, 0.0)
    for step in (unit / points, 0.0):
        for gamma in gammas:
            a, b, c = waves(form, float(gamma))
            values = a * np.sin(2 * betas) + b * np.sin(4 * betas) + c * np.sin(2 * betas) ** 2
            at = int(values.argmin())
            found = min(found, (float(values[at]), float(gamma), float(betas[at])))
        gammas = found[1] + np.linspace(-step, step, 21)
        betas = found[2] + np.linspace(-np.pi / angles, np.pi / angles, 41)
    return found[1], found[2], form.mean + found[0]


def ramp(layers: int, gamma: float, beta: float) -> tuple[Floats, Floats]:
    """Return gammas rising towards `gamma` and betas falling from `beta`, shape (layers,)."""
    at = (np.arange(layers) + 0.5) / layers
    return gamma * at, beta * (1 - at)
