"""matplotlib: a picture of two halves, its pixels, and the size that its PNG tells."""

import io
import struct

import numpy as np

from qrobot.health.check import Check

WIDTH, HEIGHT = 16, 10
LEFT, RIGHT = (0.2, 0.4, 0.8), (1.0, 0.0, 0.6)
"""Colours that are whole numbers of 255ths."""


def answer() -> list[float]:
    """Return the sum of each colour in each half, and width and height of the file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    figure = Figure(figsize=(WIDTH / 50, HEIGHT / 50), dpi=50, facecolor=RIGHT)
    canvas = FigureCanvasAgg(figure)
    figure.add_artist(Rectangle((0, 0), 0.5, 1, facecolor=LEFT, linewidth=0))
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba(), dtype=float)
    sums = [pixels[:, half, :3].sum(axis=(0, 1)) for half in (slice(8), slice(8, None))]
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return [*np.concatenate(sums).tolist(), *struct.unpack(">II", file.getvalue()[16:24])]


def expected() -> list[float]:
    """Return pixels times colour; the PNG's header holds its size in bytes 16 to 23."""
    pixels = WIDTH * HEIGHT / 2
    return [*(255 * shade * pixels for shade in (*LEFT, *RIGHT)), WIDTH, HEIGHT]


CHECK = Check(
    __name__,
    title="a picture's pixels",
    group="solver",
    imports=("matplotlib.figure", "matplotlib.backends.backend_agg"),
    distributions=("matplotlib",),
    source="pixels times colour; the PNG specification, section 11.2.1",
    tolerance=1e-6,
    extra="plot",
)
