"""The page kit: one frame, one table, one chart and one style for every page that we write."""

from qrobot.pages.kit import Bar, bars, render

__all__ = ["Bar", "bars", "render"]
