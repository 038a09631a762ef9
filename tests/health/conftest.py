from health.commands import planted
from remote.conftest import home

__all__ = ["home", "planted"]
