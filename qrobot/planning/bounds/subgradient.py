"""Subgradient steps on the prices of stops: what both Lagrangian bounds climb with.

B. T. Polyak, USSR Computational Mathematics and Mathematical Physics 9 (1969) 14; the step is
halved where the bound stops rising, as M. Held, P. Wolfe and H. P. Crowder, Mathematical
Programming 6 (1974) 62, do.
"""

from __future__ import annotations

from collections.abc import Callable

from qrobot._arrays import Floats

__all__ = ["climb"]

Relaxation = Callable[[Floats], tuple[float, Floats] | None]
"""From prices, shape (n,), to a valid bound and its slope; ``None`` when stopped."""


def climb(
    relaxation: Relaxation,
    prices: Floats,
    *,
    best: float,
    upper: float,
    stop: Callable[[], bool],
    rounds: int,
    stale_rounds: int,
    narrowest: float,
) -> float:
    """Return the best bound that changes of prices lead to.

    Parameters
    ----------
    relaxation
        The relaxed question under prices.
    prices
        The first prices.
    best
        A bound that is known already.
    upper
        Cost of a known plan: sets the length of the steps.
    stop
        Asked every round.
    rounds
        Most rounds.
    stale_rounds
        Rounds without a better bound before the steps are halved.
    narrowest
        Part of the first step's length that ends the search.

    Returns
    -------
    float
        At least `best`, less a relative 1e-9 that covers the rounding of summed prices.
    """
    width, stale = 1.0, 0
    for _ in range(rounds):
        found = None if stop() else relaxation(prices)
        if found is None:
            break
        bound, slope = found
        if bound > best * (1 + 1e-9):
            best, stale = bound, 0
        elif (stale := stale + 1) == stale_rounds:
            width, stale = width / 2, 0
        length = float(slope @ slope)
        if length < 1e-12 or width < narrowest:
            break
        prices = prices + width * max(upper - bound, 1e-3 * upper) / length * slope
    return best * (1 - 1e-9)
