"""Steepest descent: local minima, repeatable, dimod's own sampler tests."""

from __future__ import annotations

import unittest

import dimod
import dimod.testing
import pytest

from qrobot.backends.annealing.samplers import DescentSampler
from qrobot.errors import InputError


@dimod.testing.load_sampler_bqm_tests(DescentSampler)
class TestDescent(unittest.TestCase):
    def test_api(self) -> None:
        dimod.testing.assert_sampler_api(DescentSampler())

    def test_reads_are_local_minima_and_repeatable(self) -> None:
        bqm = dimod.generators.gnm_random_bqm(12, 40, "BINARY", random_state=3)
        samples = DescentSampler().sample(bqm, num_reads=20, seed=5)
        again = DescentSampler().sample(bqm, num_reads=20, seed=5 + 2**32)
        assert (samples.record.sample == again.record.sample).all()
        for row in samples.record.sample:
            here = bqm.energy((row, samples.variables))
            for i in range(12):
                other = row.copy()
                other[i] ^= 1
                assert bqm.energy((other, samples.variables)) >= here - 1e-9

    def test_nan_is_refused(self) -> None:
        with pytest.raises(InputError, match="not a finite number"):
            DescentSampler().sample(dimod.BQM({"a": float("nan")}, {}, 0, "BINARY"))
        with pytest.raises(InputError, match="num_reads: -1 is not a whole number of 1 or more"):
            DescentSampler().sample(dimod.BQM({"a": 1}, {}, 0, "BINARY"), num_reads=-1)
