"""The paper's tables and figures again: its rows, our methods, its seconds beside ours."""

from qrobot.study.reproduce.runner import TARGETS, Settings, reproduce

__all__ = ["TARGETS", "Settings", "reproduce"]
