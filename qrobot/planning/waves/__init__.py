"""Waves: a large pool of orders cut into parts that are planned one after the other."""

from qrobot.planning.waves.cutting import WAYS, cut
from qrobot.planning.waves.outcome import WAVES_SCHEMA, Comparison, Wave, Waves
from qrobot.planning.waves.running import plan_waves

__all__ = ["WAVES_SCHEMA", "WAYS", "Comparison", "Wave", "Waves", "cut", "plan_waves"]
