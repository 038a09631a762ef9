"""Conformance suites: inherit from one and pytest holds your backend to what it declares.

::

    from qrobot.backends.testing import SamplerConformance

    class TestMine(SamplerConformance):
        def make(self):
            return MySampler()

The suites do not need pytest themselves. No code of a solver, of the models or of the plan
checker judges a backend here: the rules and the optima are worked out anew.
"""

from qrobot.backends.testing.cases import Case, cases, scattered, verify
from qrobot.backends.testing.planners import PlannerConformance
from qrobot.backends.testing.samplers import SamplerConformance

__all__ = [
    "Case",
    "PlannerConformance",
    "SamplerConformance",
    "cases",
    "scattered",
    "verify",
]
