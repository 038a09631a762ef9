"""The page kit: one frame, one table, one chart and one style for every page that we write."""

from qrobot.pages.kit import Bar, Script, bars, render, script

__all__ = ["Bar", "Script", "bars", "render", "script"]
