"""What the domain calls ``items[3].weight``, as a place in the file that it came from."""

from __future__ import annotations

from collections.abc import Callable

from qrobot.errors import InputError
from qrobot.problem import Instance

__all__ = ["Where", "checked"]

Where = Callable[[str], str]
"""From a path of the domain to a line and column of the file."""


def checked(make: Callable[[], Instance], where: Where) -> Instance:
    """Return an instance with all that can be wrong with it found out, and told by place.

    Parameters
    ----------
    make
        Makes the instance.
    where
        Tells where the file has what an error of the domain is about.

    Raises
    ------
    InputError
        With the place in the file.
    """
    try:
        instance = make()
        _ = instance.place_distances, instance.unit
    except InputError as error:
        raise InputError(
            error.problem,
            source=error.source,
            field=where(error.field) if error.field else None,
            advice=error.advice,
        ) from None
    return instance
