"""All plans of a small instance, as basis states of the reduced encoding.

A plan is written as one sequence of n + K - 1 symbols: robot 0's stops, a zero, robot 1's
stops, a zero, and so on. Robots are told apart, as in the encoding. Each sequence stands for
exactly one bit string, the one that `PickingModel.encode` gives: robot p is at its t-th stop in
step t and stays at the depot (node 0) after its last one, and its slack bits fill the load up to
the capacity. Waiting earlier, or passing the depot between stops, would be other bit strings of
the same plan: they are not states here. For one robot the sequences are the n! tours and every
feasible bit string is one of them (with one value of the slack).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.backends.gate import resources
from qrobot.errors import BackendError, InfeasibleError
from qrobot.models.fleet import fleet_of
from qrobot.models.slack import Slack, slack_bits, slack_coefficients
from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough

__all__ = ["FeasibleSet", "all_sequences", "feasible_set", "slack_label", "x_label"]


MOST = 20_000_000
"""Most sequences (before capacity) that are enumerated."""


@dataclass(frozen=True, eq=False)
class FeasibleSet:
    """The feasible plans of an instance and their distances.

    Parameters
    ----------
    instance
        The question.
    sequences
        One plan a row, shape (N, n + K - 1), sorted; 0 separates robots.
    costs
        Distance of each plan, shape (N,).
    """

    instance: Instance
    sequences: npt.NDArray[np.uint8]
    costs: Floats

    @property
    def size(self) -> int:
        """Number of states N."""
        return len(self.costs)

    @cached_property
    def capacities(self) -> npt.NDArray[np.int64]:
        """Of each robot in units, largest first, shape (K,): the vehicles of the reduced model."""
        return fleet_of(self.instance, every_robot=True).capacities

    @cached_property
    def codes(self) -> npt.NDArray[np.int64]:
        """Each sequence as one number, rising."""
        found: npt.NDArray[np.int64] = self.sequences.astype(np.int64) @ self._places
        return found

    @cached_property
    def _places(self) -> npt.NDArray[np.int64]:
        length, base = self.sequences.shape[1], self.instance.size + 1
        return np.array([base**k for k in reversed(range(length))], dtype=np.int64)

    @cached_property
    def optimal(self) -> npt.NDArray[np.intp]:
        """Indices of all plans of least distance (to 1e-9 of it)."""
        least = float(self.costs.min())
        return np.flatnonzero(self.costs <= least + 1e-9 * max(least, 1e-300))

    def swapped(self, a: int, b: int) -> npt.NDArray[np.intp]:
        """Return for each state the one with positions a and b exchanged, shape (N,).

        Where the exchange breaks a capacity or splits an order, the state itself.
        """
        at_a = self.sequences[:, a].astype(np.int64)
        at_b = self.sequences[:, b].astype(np.int64)
        codes = self.codes + (at_b - at_a) * (self._places[a] - self._places[b])
        found = np.minimum(np.searchsorted(self.codes, codes), self.size - 1)
        return np.where(self.codes[found] == codes, found, np.arange(self.size)).astype(np.intp)

    def routes(self, index: int) -> list[list[int]]:
        """Return the stops of each robot in one state."""
        found: list[list[int]] = [[]]
        for symbol in self.sequences[index].tolist():
            if symbol:
                found[-1].append(symbol)
            else:
                found.append([])
        return found

    def lengths(self, indices: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
        """Return how far the robots drive in some states; ``inf`` where no way leads."""
        if math.isinf(self.instance.longest_useful):
            return np.asarray(self.costs[indices])
        return np.array([self.instance.length(self.routes(int(i))) for i in indices])

    def assignment(self, index: int, slack: Slack | None = None) -> set[str]:
        """Return the labels of the variables that are 1 in a state's bit string.

        Parameters
        ----------
        index
            The state.
        slack
            Kind of the model's slack; ``None`` leaves the slack out.
        """
        instance = self.instance
        found: set[str] = set()
        for p, route in enumerate(self.routes(index)):
            stops = route + [0] * (instance.size - len(route))
            found |= {x_label(t, node, p) for t, node in enumerate(stops, start=1)}
            if slack is not None:
                room = int(self.capacities[p])
                left = room - sum(int(instance.weights[node - 1]) for node in route)
                bits = slack_bits(left, slack_coefficients(room, slack))
                found |= {slack_label(k, p) for k in np.flatnonzero(bits).tolist()}
        return found


def x_label(step: int, node: int, robot: int = 0) -> str:
    """Return the name of a variable in `qrobot.models`; robots count from 0 here, 1 there."""
    return f"x[{step},{node},{robot + 1}]"


def slack_label(bit: int, robot: int = 0) -> str:
    """Return the name of a slack variable in `qrobot.models`."""
    return f"slack[{robot + 1},{bit}]"


def all_sequences(count: int) -> npt.NDArray[np.uint8]:
    """Return the permutations of 1..count, shape (count!, count)."""
    found = np.zeros((1, 0), dtype=np.uint8)
    for k in range(1, count + 1):
        wider = np.empty((k, len(found), k), dtype=np.uint8)
        for at in range(k):
            wider[at, :, :at] = found[:, :at]
            wider[at, :, at] = k
            wider[at, :, at + 1 :] = found[:, at:]
        found = wider.reshape(-1, k)
    return found


def feasible_set(instance: Instance) -> FeasibleSet:
    """Enumerate the feasible plans.

    Raises
    ------
    BackendError
        When there are too many sequences to enumerate, before any is made.
    InfeasibleError
        When no plan fits the capacities.
    """
    n, capacities = instance.size, fleet_of(instance, every_robot=True).capacities
    robots = len(capacities)
    total = math.factorial(n) * math.comb(n + robots - 1, robots - 1)
    what = f"{total:,} sequences of {n} items and {robots} robots"
    if total > MOST or (n + 1) ** (n + robots - 1) >= 2**63:
        raise BackendError(f"{what} are too many to enumerate; use at most {MOST:,}")
    resources.require(total * (2 * (n + robots) + 40), what)
    tours = all_sequences(n)
    weights = np.concatenate([[0], instance.weights])[tours]
    distances, parts, costs = instance.distances, [], []
    for cuts in combinations(range(n + robots - 1), robots - 1):
        ends = [cut - k for k, cut in enumerate(cuts)]
        segments = list(zip([0, *ends], [*ends, n], strict=True))
        fits = np.ones(len(tours), dtype=bool)
        for (a, b), capacity in zip(segments, capacities, strict=True):
            fits &= weights[:, a:b].sum(axis=1) <= capacity
        if robots > 1 and len(instance.orders) < n:
            fits &= _whole(instance, tours, segments)
        chosen = tours[fits]
        sequences = np.zeros((len(chosen), n + robots - 1), dtype=np.uint8)
        cost = np.zeros(len(chosen))
        for p, (a, b) in enumerate(segments):
            sequences[:, a + p : b + p] = chosen[:, a:b]
            if b > a:
                cost += distances[0, chosen[:, a]] + distances[chosen[:, b - 1], 0]
                for k in range(a, b - 1):
                    cost += distances[chosen[:, k], chosen[:, k + 1]]
        parts.append(sequences)
        costs.append(cost)
    made = FeasibleSet(instance, np.concatenate(parts), np.concatenate(costs))
    if not made.size:
        raise InfeasibleError(
            f"no plan fits the capacities of the robots; {what_is_enough(instance)}"
        )
    order = np.argsort(made.codes, kind="stable")
    return FeasibleSet(instance, made.sequences[order], made.costs[order])


def _whole(
    instance: Instance, tours: npt.NDArray[np.uint8], segments: list[tuple[int, int]]
) -> npt.NDArray[np.bool_]:
    """Return which tours, cut into segments, keep every order on one robot."""
    robot = np.zeros(tours.shape, dtype=np.uint8)
    for p, (a, b) in enumerate(segments):
        robot[:, a:b] = p
    carrier = np.zeros((len(tours), instance.size + 1), dtype=np.uint8)
    np.put_along_axis(carrier, tours.astype(np.intp), robot, axis=1)
    fits = np.ones(len(tours), dtype=bool)
    for nodes in instance.order_nodes:
        fits &= (carrier[:, list(nodes)] == carrier[:, [nodes[0]]]).all(axis=1)
    return fits
