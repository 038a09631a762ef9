"""What a row asks, its proven optimum, and what random guessing would give."""

from __future__ import annotations

from dataclasses import dataclass

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.backends.gate import Spectrum, expected_best, feasible_set, spectrum
from qrobot.errors import BackendError
from qrobot.models import PickingModel, build_model
from qrobot.planning import solve
from qrobot.problem import Instance
from qrobot.study.reproduce.instances import ENUMERATED, table_instance
from qrobot.study.reproduce.paper import PaperRow

__all__ = ["Control", "Question", "same"]


STREAM = 0xC0
"""Sets the control's random numbers apart from a method's with the same seed."""


def same(distances: Floats, optimum: float) -> npt.NDArray[np.bool_]:
    """Return which distances are the optimum, to 1e-9 of it."""
    return np.asarray(distances <= optimum * (1 + 1e-9))


@dataclass(frozen=True, slots=True)
class Control:
    """What random guesses of one kind give.

    Parameters
    ----------
    kind
        ``bit strings`` (uniform over all qubits) or ``plans`` (uniform feasible plans).
    feasible, probability
        Of one guess being feasible, and optimal: exact, by counting all plans.
    best
        Least distance of as many guesses as reads, drawn with the seed; ``None`` when none
        was feasible.
    """

    kind: str
    feasible: float
    probability: float
    best: float | None


@dataclass(frozen=True, eq=False)
class Question:
    """A row's instance with all that is known about it.

    Parameters
    ----------
    row
        Of the paper.
    instance
        Ours in its shape.
    model
        In the row's encoding with the paper's slack and the measured penalties.
    optimum
        Least distance, proven by the exact planner.
    plans
        How many plans have which distance: enumerated up to 9 items, then counted.
    """

    row: PaperRow
    instance: Instance
    model: PickingModel
    optimum: float
    plans: Spectrum

    @classmethod
    def of(cls, row: PaperRow, seed: int) -> Question:
        """Pose a row's question.

        Raises
        ------
        BackendError
            When the exact planner and the count of all plans do not agree, or the model has
            another number of qubits than the paper's: then every figure would be worthless.
        """
        instance = table_instance(row, seed)
        model = build_model(instance, row.encoding, slack="paper")
        proven = solve(instance, backend="exact", deadline=600)
        if proven.ended == "interrupted":  # `solve` keeps Ctrl-C to itself
            raise KeyboardInterrupt
        plans = spectrum(instance) if row.items > ENUMERATED else _enumerated(instance)
        if not (proven.is_optimal and abs(proven.cost - plans.levels[0]) < 1e-6):
            raise BackendError(
                f"the exact planner says {proven.cost:g} for {row.items} items, counting all "
                f"plans says {plans.levels[0]:g}"
            )
        if model.num_variables != row.qubits:
            raise BackendError(
                f"the model of {row.items} items has {model.num_variables} qubits, the paper's "
                f"{row.qubits}"
            )
        return cls(row, instance, model, proven.cost, plans)

    def bit_strings(self, reads: int, seed: int) -> Control:
        """Return what uniform bit strings give, whatever their slack bits say.

        With one robot every plan is one setting of the x variables, so the shares follow
        from the number of plans.
        """
        settings = 2.0**self.model.layout.places
        rng = np.random.default_rng([seed, STREAM])
        bits = rng.integers(2, size=(reads, self.model.num_variables), dtype=np.int8)
        drawn = dimod.SampleSet.from_samples_bqm((bits, self.model.variables), self.model.bqm)
        best = float(self.model.decode_all(drawn).distances.min())
        return Control(
            "bit strings",
            feasible=self.plans.size / settings,
            probability=self.plans.optimal / settings,
            best=best if np.isfinite(best) else None,
        )

    def random_plans(self, reads: int, seed: int) -> Control:
        """Return what uniform feasible plans give."""
        shares = self.plans.counts / self.plans.size
        drawn = np.random.default_rng([seed, STREAM]).choice(self.plans.levels, reads, p=shares)
        return Control("plans", 1.0, self.plans.optimal / self.plans.size, float(drawn.min()))

    def expected_best_plan(self, reads: int) -> float:
        """Return the expected best distance of as many uniform feasible plans."""
        return expected_best(self.plans.levels, self.plans.counts / self.plans.size, reads)


def _enumerated(instance: Instance) -> Spectrum:
    """Return how many plans have which distance, by listing them."""
    costs = np.sort(feasible_set(instance).costs)
    # Both directions of a tour differ in the last digits.
    first = np.concatenate([[True], np.diff(costs) > 1e-9 * costs[-1]])
    starts = np.flatnonzero(first)
    return Spectrum(costs[starts], np.diff([*starts.tolist(), len(costs)]))
