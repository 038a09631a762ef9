"""The machine below the stacks: what it is, and whether qRobot can live with it.

`Machine` gathers the raw facts; one file a subject judges them. Nothing here raises, whatever
is missing or malformed: what cannot be told is ``unknown``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from qrobot.health.model import Finding
from qrobot.health.system.hardware import board, board_model, processor
from qrobot.health.system.machine import Machine
from qrobot.health.system.memory import memory
from qrobot.health.system.software import clock, software

__all__ = ["Machine", "board_model", "system_findings"]

PROBES: tuple[Callable[[Machine], Iterable[Finding]], ...]
PROBES = (board, processor, software, memory, clock)


def system_findings(machine: Machine | None = None, *, network: bool = False) -> list[Finding]:
    """Return what there is to say about the machine, within a second.

    Parameters
    ----------
    machine
        By default the one we are on.
    network
        Also whether the services' endpoints can be reached, which takes some seconds.
    """
    machine = machine or Machine()
    found: list[Finding] = []
    for probe in PROBES:
        name = probe.__name__
        try:
            for finding in probe(machine):  # one by one: what came before an error is kept
                found.append(finding)  # noqa: PERF402
        except Exception as error:
            text = f"could not be told: {type(error).__name__}"
            found.append(Finding(name, name.capitalize(), "unknown", None, text))
    if network:
        from qrobot.health.system.network import network_findings

        found += network_findings()
    return found
