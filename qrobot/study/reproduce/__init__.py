"""The paper's tables and figures again: its rows, our methods, its seconds beside ours."""

from qrobot.study.reproduce.runner import TARGETS, reproduce
from qrobot.study.reproduce.settings import Settings

__all__ = ["TARGETS", "Settings", "reproduce"]
