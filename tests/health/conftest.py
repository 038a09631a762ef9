from health.commands import planted
from health.made_up import no_tool
from jobs.conftest import home

__all__ = ["home", "no_tool", "planted"]
