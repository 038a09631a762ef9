"""The solvers that the fake solver API offers, with properties as D-Wave's have them."""

from __future__ import annotations

TIMING = {
    "version": "1.0.0",
    "typical_programming_time": 14072.68,
    "reverse_annealing_with_reinit_prog_time_delta": 0.0,
    "reverse_annealing_without_reinit_prog_time_delta": 4.55,
    "default_programming_thermalization": 0.0,
    "default_annealing_time": 20.0,
    "readout_time_model": "pwl_log_log",
    "readout_time_model_parameters": [0.0, 0.7, 1.0, 1.2, 1.3, 1.5],
    "qpu_delay_time_per_sample": 21.0,
    "reverse_annealing_with_reinit_delay_time_delta": -4.5,
    "reverse_annealing_without_reinit_delay_time_delta": -1.5,
    "default_readout_thermalization": 0.0,
    "decorrelation_max_nominal_anneal_time": 2000.0,
    "decorrelation_time_range": [500.0, 10000.0],
}


def solvers():
    from dwave.system.testing import MockDWaveSampler

    mock = MockDWaveSampler(topology_type="pegasus", topology_shape=[3])
    qpu = dict(mock.properties) | {"problem_timing_data": TIMING, "chip_id": "Fake_QPU"}
    hybrid = {
        "category": "hybrid",
        "supported_problem_types": ["bqm"],
        "parameters": {"time_limit": "seconds"},
        "minimum_time_limit": [[1, 3.0], [1024, 3.0], [4096, 10.0]],
        "maximum_time_limit_hrs": 24.0,
        "quota_conversion_rate": 20,
        "version": "2.2",
    }
    nonlinear = {
        "category": "hybrid",
        "supported_problem_types": ["nl"],
        "parameters": {"time_limit": "seconds"},
        "maximum_number_of_states": 10,
        "quota_conversion_rate": 20,
        "version": "1.0",
    }
    cqm = hybrid | {
        "supported_problem_types": ["cqm"],
        "minimum_time_limit_s": 5,
        "maximum_number_of_constraints": 100,
        "maximum_number_of_variables": 1000,
        "maximum_number_of_biases": 100000,
        "maximum_number_of_quadratic_variables": 0,
    }
    common = {"status": "ONLINE", "avg_load": 0.1, "description": ""}
    return [
        common
        | {"identity": {"name": "Fake_QPU", "version": {"graph_id": "01"}}, "properties": qpu},
        common | {"identity": {"name": "fake_hybrid_bqm"}, "properties": hybrid},
        common | {"identity": {"name": "fake_hybrid_cqm"}, "properties": cqm},
        common | {"identity": {"name": "fake_hybrid_nl"}, "properties": nonlinear},
    ]
