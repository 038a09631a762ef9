"""What a parameter takes, declared once and checked by one function, and near names.

Samplers declare theirs (`qrobot.backends.sampler`), remote jobs and `solve` too: a value of the
wrong type or out of range is refused by its name, with all that is allowed.
"""

from __future__ import annotations

import difflib
import math
import numbers
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from qrobot.errors import InputError

__all__ = ["Parameter", "near"]

Kind = Literal[
    "whole",
    "number",
    "numbers",
    "pairs",
    "flag",
    "choice",
    "text",
    "names",
    "function",
    "object",
    "any",
]


LONGEST = 60
"""Characters of a refused value that are shown."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """What one parameter takes.

    Parameters
    ----------
    kind
        ``whole`` and ``number`` (finite), ``numbers`` (a list of them), ``pairs`` (a list of
        lists of two numbers), ``flag`` (true or false), ``choice`` (one of `choices`), ``text``,
        ``names`` (values by name), ``function``, ``object`` (only those of `also`), or ``any``,
        which its sampler judges.
    least, most
        Range of a number, or of each of several.
    above
        Whether `least` itself is refused.
    length
        How many `numbers`; ``None``: any.
    choices
        The words of a ``choice``.
    optional
        Whether ``None`` stands for the default.
    also
        Classes whose objects are taken too, such as a mapping of numbers for a number.
    """

    kind: Kind
    least: float | None = None
    most: float | None = None
    above: bool = False
    length: int | None = None
    choices: tuple[str, ...] = ()
    optional: bool = True
    also: tuple[Any, ...] = ()

    def check(self, name: str, value: Any) -> None:
        """Refuse a value that the parameter does not take.

        Raises
        ------
        InputError
            With the parameter's name, the value and all that is allowed.
        """
        if value is None:
            allowed = self.optional
        else:
            allowed = self._takes(value) or isinstance(value, self.also)
        if allowed:
            return
        advice = "leave it out, or correct it" if self.optional else "correct it"
        if self.kind == "choice" and isinstance(value, str):
            advice = near(value, self.choices) or advice
        raise InputError(f"{_shown(value)} is not {self.allowed}", field=name, advice=advice)

    @property
    def allowed(self) -> str:
        """What is taken, in words: ``a whole number of 1 or more``."""
        words = {
            "whole": f"a whole number{self._range}",
            "number": f"a finite number{self._range}",
            "numbers": f"a list of {self.length or 'finite'} numbers"
            + (f", each{self._range}" if self._range else ""),
            "pairs": "a list of pairs of finite numbers",
            "flag": "true or false",
            "choice": f"one of {', '.join(self.choices)}",
            "text": "text",
            "names": "values by name",
            "function": "a function",
            "object": f"a {' or '.join(one.__name__ for one in self.also)}",
            "any": "usable",
        }
        return words[self.kind]

    @property
    def _range(self) -> str:
        least, most = (None if end is None else f"{end:.15g}" for end in (self.least, self.most))
        if least is None:
            return "" if most is None else f" of at most {most}"
        if self.above:
            return f" above {least}" + ("" if most is None else f" and at most {most}")
        return f" of {least} or more" if most is None else f" from {least} to {most}"

    def _takes(self, value: Any) -> bool:
        match self.kind:
            case "whole" | "number":
                return self._is_number(value)
            case "numbers":
                return self._are_numbers(value)
            case "pairs":
                pair = Parameter("numbers", length=2)
                return _is_list(value) and all(pair._takes(one) for one in value)
            case "flag":
                return isinstance(value, bool) or type(value).__name__ in ("bool_", "bool")
            case "choice":
                return isinstance(value, str) and value in self.choices
            case "text":
                return isinstance(value, str) and bool(value.strip())
            case "names":
                return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)
            case "function":
                return callable(value)
        return self.kind == "any"

    def _is_number(self, value: Any) -> bool:
        kind = numbers.Integral if self.kind == "whole" else numbers.Real
        if isinstance(value, bool) or not isinstance(value, kind):
            return False
        try:
            number = float(value)
        except OverflowError:  # beyond all floats
            return False
        if not math.isfinite(number):
            return False
        least = -math.inf if self.least is None else self.least
        most = math.inf if self.most is None else self.most
        return least <= number <= most and not (self.above and number == least)

    def _are_numbers(self, value: Any) -> bool:
        if not _is_list(value):
            return False
        return self.length in (None, len(value)) and all(map(self._is_number, value))


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _is_list(value: Any) -> bool:
    """Whether a value is a sequence, or an array with dimensions."""
    if isinstance(value, str | bytes | Mapping):
        return False
    return isinstance(value, Sequence) or bool(getattr(value, "shape", ()))


def near(name: str, known: Iterable[str]) -> str:
    """Return ``did you mean ...?`` for a name that is like a known one, else nothing."""
    spelled = {other.replace("_", "").replace("-", "").lower(): other for other in sorted(known)}
    found = difflib.get_close_matches(
        name.replace("_", "").replace("-", "").lower(), spelled, n=1, cutoff=0.7
    )
    return f"did you mean {spelled[found[0]]}?" if found else ""
