"""What the domain calls ``items[3].weight``, as a place in the file that it came from."""

from __future__ import annotations

from collections.abc import Callable

from qrobot.errors import InputError
from qrobot.problem import Instance

__all__ = ["Where", "checked"]

Where = Callable[[str], str]
"""From a path of the domain to a line and column of the file."""


def checked(make: Callable[[], Instance], where: Where) -> Instance:
    """Return what `make` makes, with all that can be wrong with it found out and told by place."""
    try:
        instance = make()
        _ = instance.place_distances, instance.unit
    except InputError as error:
        raise error.at(where(error.field) if error.field else None) from None
    return instance
