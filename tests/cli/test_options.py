"""What has a flag of its own is not an option of a sampler."""

from __future__ import annotations

import inspect

import pytest

import qrobot
from qrobot.cli.options import OWN_FLAGS, Setting
from qrobot.errors import InputError

OWN = [
    name
    for name, parameter in inspect.signature(qrobot.solve).parameters.items()
    if parameter.kind is not inspect.Parameter.VAR_KEYWORD
]


@pytest.mark.parametrize("name", OWN)
def test_an_argument_of_solve_cannot_be_given_as_an_option(name: str) -> None:
    assert name in OWN_FLAGS
    with pytest.raises(InputError, match=f"{name} is not an option of a sampler here"):
        Setting().convert(f"{name}=1", None, None)
