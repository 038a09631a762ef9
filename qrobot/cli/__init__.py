"""The command line: one file a command, no logic.

Exit codes: 0 done, 1 infeasible or unhealthy, 2 bad input, 3 a backend failed,
130 interrupted before there was anything to keep.
"""

from qrobot.cli.main import main

__all__ = ["main"]
