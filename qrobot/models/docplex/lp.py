"""A docplex model as text in CPLEX's LP format."""

from __future__ import annotations

import io
from typing import Any

from qrobot._extras import load

__all__ = ["lp_name", "lp_text"]


def lp_name(label: str) -> str:
    """Return the name that a variable or constraint has in LP files: ``x_1_0_2``.

    A bracket begins the quadratic part there; commas and parentheses are read by some
    solvers only.
    """
    return label.replace("[", "_").replace(",", "_").replace("]", "")


def lp_text(model: Any) -> str:
    """Return a model of `picking_docplex` in the LP format.

    Numbers are written with 12 decimals, as docplex does it.

    Parameters
    ----------
    model
        A `docplex.mp.model.Model`.

    Raises
    ------
    MissingExtraError
        When docplex is not installed.
    """
    base: Any = load("docplex.mp.lp_printer", "an LP file").LPModelPrinter

    # By itself it would call x[1,0,2] just x3; renaming the variables, or a copy of the
    # model, makes docplex write to the terminal.
    class Printer(base):  # type: ignore[misc]
        def fix_name(self, mobj: Any, *_: object) -> str:
            return lp_name(str(mobj.name))

    text = io.StringIO()
    Printer().printModel(model, text)
    return text.getvalue()
