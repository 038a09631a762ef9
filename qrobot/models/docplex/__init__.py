"""The constrained model in docplex: as LP file, and through Qiskit to a penalty form.

docplex and qiskit-optimization are imported when a function needs them.
"""

from qrobot.models.docplex.lp import lp_name, lp_text
from qrobot.models.docplex.penalise import bqm_from_docplex
from qrobot.models.docplex.picking import DOCPLEX_ENCODINGS, picking_docplex

__all__ = ["DOCPLEX_ENCODINGS", "bqm_from_docplex", "lp_name", "lp_text", "picking_docplex"]
