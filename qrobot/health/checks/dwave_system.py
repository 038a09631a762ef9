"""D-Wave's Ocean against its mock QPU: embed, sample, unembed; the best read is the ground state.

What comes back has energies of the model, whatever went to the device. So the states must be good:
the mock is a heuristic, but a model of eight spins it solves in a tenth of its reads.
"""

import numpy as np

from qrobot.health import known
from qrobot.health.check import Check

READS = 200


def answer() -> list[float]:
    """Return the reads, the largest error of an energy, and the lowest energy."""
    from dwave.system import EmbeddingComposite
    from dwave.system.testing import MockDWaveSampler

    device = MockDWaveSampler(topology_type="pegasus", topology_shape=[2])
    try:
        found = EmbeddingComposite(device).sample(known.model(), num_reads=READS)
    finally:
        device.close()
    order = [list(found.variables).index(k) for k in range(len(known.FIELDS))]
    energies = np.asarray(found.record.energy, dtype=float)
    true = known.energies(found.record.sample[:, order])
    return [found.record.num_occurrences.sum(), np.abs(energies - true).max(), energies.min()]


def expected() -> list[float]:
    """Return all reads, no error, and the ground state energy."""
    return [READS, 0.0, known.lowest()]


CHECK = Check(
    __name__,
    title="embedding on a mock QPU",
    group="annealing",
    imports=("dwave.system", "dwave.system.testing"),
    distributions=("dwave-system", "dwave-cloud-client"),
    source="all 256 states in numpy",
    extra="dwave",
)
