"""Figures of the models: building and decoding are quick."""

from __future__ import annotations

import time

import dimod
import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.models import build_model


@pytest.mark.figure
def test_a_reduced_model_of_twelve_items_and_three_robots_is_built_in_30_ms() -> None:
    instance = paper_shaped(12, 3, 0)
    seconds = []
    for _ in range(9):
        begun = time.perf_counter()
        build_model(instance, "reduced")
        seconds.append(time.perf_counter() - begun)
    assert min(seconds) <= 0.030


@pytest.mark.figure
def test_a_thousand_reads_are_decoded_in_a_tenth_of_a_second() -> None:
    model = build_model(paper_shaped(12, 3, 0), "reduced")
    rows = np.tile(model.encode_bits([[1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11, 12]]), (1_000, 1))
    rows[::3] = np.random.default_rng(0).integers(0, 2, rows[::3].shape)
    samples = dimod.SampleSet.from_samples_bqm((rows, model.variables), model.bqm)
    seconds = []
    for _ in range(5):
        begun = time.perf_counter()
        model.decode_all(samples)
        seconds.append(time.perf_counter() - begun)
    assert min(seconds) <= 0.100
