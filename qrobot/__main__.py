"""``python -m qrobot`` is the command line."""

from qrobot.cli import main

main()
