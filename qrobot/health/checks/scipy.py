"""scipy: a matrix exponential, sparse eigenvalues and an assignment."""

import itertools
import math

from qrobot.health.check import Check

ANGLE, SIZE = 0.7, 40
COSTS = ((7, 2, 9, 4), (3, 8, 5, 6), (6, 4, 1, 7), (2, 9, 8, 3))


def answer() -> list[float]:
    """Return a rotation, the largest eigenvalues of a long chain, and the least cost."""
    import numpy as np
    from scipy import linalg, optimize, sparse
    from scipy.sparse import linalg as arpack

    turn = linalg.expm(np.array([[0.0, -ANGLE], [ANGLE, 0.0]]))
    chain = sparse.diags([[-1.0] * (SIZE - 1), [2.0] * SIZE, [-1.0] * (SIZE - 1)], [-1, 0, 1])
    values = arpack.eigsh(chain.tocsr(), k=2, v0=np.arange(1.0, SIZE + 1))[0]
    rows, columns = optimize.linear_sum_assignment(np.array(COSTS))
    cost = sum(COSTS[r][c] for r, c in zip(rows, columns, strict=True))
    return [*turn.ravel().tolist(), *sorted(values.tolist()), float(cost)]


def expected() -> list[float]:
    """Return sine and cosine, the chain's formula, and the best of all permutations."""
    return [
        *(math.cos(ANGLE), -math.sin(ANGLE), math.sin(ANGLE), math.cos(ANGLE)),
        *(2 - 2 * math.cos(k * math.pi / (SIZE + 1)) for k in (SIZE - 1, SIZE)),
        min(sum(COSTS[r][c] for r, c in enumerate(p)) for p in itertools.permutations(range(4))),
    ]


CHECK = Check(
    __name__,
    title="expm, sparse eigenvalues, assignment",
    group="base",
    imports=("scipy.linalg", "scipy.sparse.linalg", "scipy.optimize"),
    distributions=("scipy",),
    source="closed forms, and all permutations",
    extra="edge",
)
