"""dwave-hybrid: a workflow that takes a model apart, improves the parts and puts them back."""

from qrobot.health import known
from qrobot.health.check import Check

TURNS = 20
"""Of the parts alone."""


def answer() -> list[float]:
    """Return the energy that a workflow tells, that of its state, and that of its parts alone.

    Tabu on all eight spins would hide a part that does nothing: the parts must do it alone too.
    """
    import hybrid

    part = (
        hybrid.Const(subsamples=None)  # those of the last round are of other spins
        | hybrid.EnergyImpactDecomposer(size=6)
        | hybrid.TabuSubproblemSampler(timeout=20)
        | hybrid.SplatComposer()
    )
    all_spins = hybrid.TabuProblemSampler(timeout=100)
    workflow = hybrid.Loop(hybrid.Parallel(part, all_spins) | hybrid.ArgMin(), max_iter=3)
    # The best of all turns: on a busy machine tabu's time may be over before it began.
    alone = hybrid.Loop(part | hybrid.TrackMin(output=True), max_iter=TURNS)
    start = hybrid.State.from_sample(dict.fromkeys(range(len(known.FIELDS)), 1), known.model())
    best = workflow.run(start).result().samples.first
    by_parts = alone.run(start).result().samples.first
    return [float(best.energy), known.energy_of(best.sample), float(by_parts.energy)]


def expected() -> list[float]:
    """Return the ground state energy, three times."""
    return [known.lowest()] * 3


CHECK = Check(
    __name__,
    title="a hybrid workflow, 8 spins",
    group="annealing",
    imports=("hybrid",),
    distributions=("dwave-hybrid",),
    source="all 256 states in numpy",
    extra="dwave",
)
