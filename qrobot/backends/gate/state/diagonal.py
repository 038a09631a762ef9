"""QAOA on any quadratic cost by its diagonal: the exact state, fast.

E. Farhi, J. Goldstone and S. Gutmann, arXiv:1411.4028 (2014). The cost is diagonal, so a layer
is one phase an amplitude and one rotation a qubit; nothing is compiled to gates.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Reals
from qrobot._machine import available_memory
from qrobot.backends.gate import resources
from qrobot.backends.gate.ansatz import best_layer
from qrobot.backends.gate.form import Form, below, bits_of, diagonal
from qrobot.backends.gate.state.engine import make_engine
from qrobot.errors import BackendError, InputError

__all__ = ["PRECISIONS", "DiagonalQAOA"]


PRECISIONS: dict[str, np.dtype[Any]] = {
    "double": np.dtype(np.float64),
    "single": np.dtype(np.float32),
}

CHUNK = 1 << 16
BINS = 1 << 16


class DiagonalQAOA:
    """The QAOA state of a quadratic cost D.

    The state is exp(-i beta_p B) exp(-i gamma_p D) ... exp(-i beta_1 B) exp(-i gamma_1 D) |+>
    with B the sum of all X. Angles that lower the cost have gamma > 0 and beta < 0.

    Parameters
    ----------
    form
        The cost.
    precision
        ``double`` (complex128) or ``single`` (complex64, half the memory; sums stay float64).
    threads
        Of the compiled engine; ``None`` uses all cores.
    engine
        ``auto``, ``numba`` or ``numpy``.
    alpha
        The objective is the mean of the lowest `alpha` of the distribution (CVaR;
        P. K. Barkoutsos et al., Quantum 4 (2020) 256); 1 is the expectation.

    Raises
    ------
    BackendError
        When memory is too small, before any of it is taken.
    InputError
        When an option is out of range.
    """

    beta_range = (-np.pi / 2, np.pi / 2)

    def __init__(
        self,
        form: Form,
        *,
        precision: str = "double",
        threads: int | None = 1,
        engine: str = "auto",
        alpha: float = 1.0,
    ) -> None:
        if precision not in PRECISIONS:
            raise InputError(
                f"{precision!r} is not a precision",
                field="precision",
                advice="use double or single",
            )
        if not 0.0 < alpha <= 1.0:
            raise InputError(
                f"alpha {alpha:g} is not a share", field="alpha", advice="use 0 < alpha <= 1"
            )
        self.form, self.alpha, self.qubits = form, alpha, form.qubits
        self.dtype = PRECISIONS[precision]
        self._require(3, "the state and the energies")
        self.engine = make_engine(engine, threads, form.qubits)
        # Energies around zero keep the digits of a phase; in double the energies stay as they are.
        self.shift = form.mean if precision == "single" else 0.0
        self.diagonal: Reals = diagonal(form, self.dtype, self.shift)
        self.re, self.im = resources.pair(self.diagonal.size, self.dtype)
        self.spread = form.spread
        self.runs = 0

    def _require(self, arrays: int, what: str) -> None:
        size = arrays * self.dtype.itemsize * 2**self.qubits
        advice = "use a smaller model"
        if self.dtype == np.float64 and size // 2 <= available_memory():
            advice = "use precision 'single'"
        resources.require(
            size, f"holding {what} of {self.qubits} qubits", advice, qubits=self.qubits
        )

    # -- the state -------------------------------------------------------------------

    def run(self, gammas: Sequence[float] | Floats, betas: Sequence[float] | Floats) -> None:
        """Make the state of the given angles; it replaces the one before."""
        if len(gammas) != len(betas) or not len(gammas):
            raise InputError(
                f"{len(gammas)} gammas and {len(betas)} betas do not make layers",
                field="betas",
                advice="give one of each a layer",
            )
        if not (np.isfinite(gammas).all() and np.isfinite(betas).all()):
            raise InputError("an angle is not a finite number", field="gammas")
        state = (self.re, self.im, self.diagonal)
        for layer, (gamma, beta) in enumerate(zip(gammas, betas, strict=True)):
            apply = self.engine.layer if layer else self.engine.begin
            apply(*state, float(gamma), float(beta))
        self.runs += 1

    def vector(self) -> npt.NDArray[np.complex128]:
        """Return a copy of the state; in single precision up to a global phase."""
        return self.re.astype(np.float64) + 1j * self.im.astype(np.float64)

    def probabilities(self, indices: npt.NDArray[np.intp] | slice) -> Floats:
        """Return the probabilities of basis states."""
        found: Floats = self.re[indices].astype(np.float64) ** 2
        found += self.im[indices].astype(np.float64) ** 2
        return found

    def expectation(self) -> float:
        """Return the mean cost."""
        mass, energy = self.engine.moments(self.re, self.im, self.diagonal)
        return energy / mass + self.shift

    def cvar(self, alpha: float | None = None) -> float:
        """Return the mean cost of the lowest `alpha` of the distribution.

        Energies are sorted into 65,536 bins, each with its own mean; only the bin that the
        share cuts is approximate.
        """
        return self._tail(self.alpha if alpha is None else alpha)[0] + self.shift

    def _tail(self, alpha: float) -> tuple[float, float]:
        """Return the mean of the tail and the energy where it ends, both less the shift."""
        low, high = self.lowest - self.shift, self.highest - self.shift
        width = max((high - low) / (BINS - 1), 1e-12 * max(abs(low), 1.0))
        mass, energy = self.engine.histogram(self.re, self.im, self.diagonal, low, width, BINS)
        filled = np.flatnonzero(mass)
        mass, energy = mass[filled], energy[filled]
        upto = np.cumsum(mass)
        share = alpha * upto[-1]
        cut = int(min(np.searchsorted(upto, share), len(upto) - 1))
        end = float(energy[cut] / mass[cut])
        before = upto[cut - 1] if cut else 0.0
        return float((energy[:cut].sum() + (share - before) * end) / share), end

    def sample(self, shots: int, rng: np.random.Generator) -> npt.NDArray[np.intp]:
        """Draw basis states, shape (shots,), in random sequence.

        Probabilities are summed in float64, chunk by chunk, and never stored as a whole.
        """
        totals = np.array(
            [self.probabilities(slice(a, a + CHUNK)).sum() for a in range(0, self.re.size, CHUNK)]
        )
        upto = np.cumsum(totals)
        draws = np.sort(rng.random(shots)) * upto[-1]
        chunk_of = np.minimum(np.searchsorted(upto, draws, side="right"), len(upto) - 1)
        found = np.empty(shots, dtype=np.intp)
        for chunk in np.unique(chunk_of):
            here = chunk_of == chunk
            start = int(chunk) * CHUNK
            within = np.cumsum(self.probabilities(slice(start, start + CHUNK)))
            left = draws[here] - (upto[chunk] - totals[chunk])
            at = np.searchsorted(within, left, side="right")
            found[here] = start + np.minimum(at, len(within) - 1)
        rng.shuffle(found)
        return found

    # -- the lowest energy -----------------------------------------------------------

    @cached_property
    def lowest(self) -> float:
        """The least energy of any assignment."""
        return float(self.diagonal.min()) + self.shift

    @cached_property
    def highest(self) -> float:
        """The greatest energy of any assignment."""
        return float(self.diagonal.max()) + self.shift

    @cached_property
    def ground(self) -> npt.NDArray[np.intp]:
        """Indices of all assignments of least energy (to 1e-9 of the spread)."""
        near = 1e-9 if self.dtype == np.float64 else 1e-4
        room = near * max(self.spread, abs(self.lowest - self.shift), 1e-300)
        found = np.flatnonzero(self.diagonal <= self.lowest - self.shift + room)
        if self.dtype == np.float64 or found.size > CHUNK:
            return found
        energies = self.form.energies(bits_of(found, self.qubits))
        exact = energies <= energies.min() + 1e-9 * max(self.spread, 1e-300)
        return np.asarray(found[exact], dtype=np.intp)

    # -- the ansatz of `tune` --------------------------------------------------------

    def guess(self) -> tuple[float, float] | None:
        """Return the best single layer for the expectation, in closed form."""
        gamma, beta, _ = best_layer(self.form)
        return gamma, beta

    def value(self, gammas: Floats, betas: Floats) -> float:
        """Return the objective at the given angles."""
        self.run(gammas, betas)
        return self.expectation() if self.alpha == 1.0 else self.cvar()

    def gradient(self, gammas: Floats, betas: Floats) -> tuple[float, Floats, Floats]:
        """Return the objective and its derivatives, by one run forward and one backward.

        Adjoint differentiation: T. Jones and J. Gacon, arXiv:2009.02823 (2020). The state is
        used up.
        """
        value = self.value(gammas, betas)
        self._require(4, "the second state for a gradient")
        weight = self.diagonal
        if self.alpha < 1.0:
            end, alpha = self._tail(self.alpha)[1], self.alpha
            weight = below(self.diagonal, self.dtype.type(end), self.dtype.type(alpha))
        lr, li = resources.pair(self.re.size, self.dtype)
        np.multiply(weight, self.re, out=lr)
        np.multiply(weight, self.im, out=li)
        by_gamma, by_beta = np.zeros(len(gammas)), np.zeros(len(betas))
        for layer in range(len(gammas) - 1, -1, -1):
            gamma, beta = float(gammas[layer]), float(betas[layer])
            by_beta[layer] = 2 * self.engine.overlap(lr, li, self.re, self.im)
            self.engine.undo(self.re, self.im, self.diagonal, gamma, beta)
            self.engine.undo(lr, li, self.diagonal, gamma, beta)
            by_gamma[layer] = 2 * self._phase_slope(lr, li)
        if not np.isfinite(value):
            raise BackendError("the objective is not a finite number: the angles are too large")
        return value, by_gamma, by_beta

    def _phase_slope(self, lr: Reals, li: Reals) -> float:
        total = 0.0
        for a in range(0, lr.size, CHUNK):
            part = np.s_[a : a + CHUNK]
            turned = lr[part] * self.im[part] - li[part] * self.re[part]
            total += float((turned * self.diagonal[part]).sum(dtype=np.float64))
        return total
