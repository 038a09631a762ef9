"""Instance to binary quadratic model, and samples back to routes."""

from qrobot.models.ising import Ising, to_ising
from qrobot.models.model import ENCODINGS, PickingModel, build_model, model_for
from qrobot.models.penalties import Penalties
from qrobot.models.samples import Decoded, Reads, Violation

__all__ = [
    "ENCODINGS",
    "Decoded",
    "Ising",
    "Penalties",
    "PickingModel",
    "Reads",
    "Violation",
    "build_model",
    "model_for",
    "to_ising",
]
