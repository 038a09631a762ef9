# %% [markdown]
# # matplotlib: pictures without a screen
#
# A robot has no screen, but plans and reports need pictures. matplotlib draws into memory with
# *Agg*, a renderer in C++, and writes PNG or SVG. `qrobot solve --picture plan.png` uses it.

# %%
import io
import struct

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from qrobot.health.checks.matplotlib import CHECK, HEIGHT, LEFT, RIGHT, WIDTH
from qrobot.health.lesson import draw, verdict

draw(
    lambda axes: (
        axes.add_patch(Rectangle((0, 0), 0.5, 1, facecolor=LEFT)),
        axes.add_patch(Rectangle((0.5, 0), 0.5, 1, facecolor=RIGHT)),
    ),
    size=(3, 1.6),
)

# %% [markdown]
# ## A picture is an array
#
# Four bytes a pixel: red, green, blue and how opaque. An edge that lies between two pixels is
# blended (anti-aliased). Here a black half ends in the middle of pixel 4 of 8:

# %%
figure = Figure(figsize=(8 / 50, 1 / 50), dpi=50, facecolor="white")
canvas = FigureCanvasAgg(figure)
edge = Rectangle((0, 0), 3.5 / 8, 1, facecolor="black", linewidth=0, antialiased=True, snap=False)
figure.add_artist(edge)
canvas.draw()
print(np.asarray(canvas.buffer_rgba())[0, :, 0])

# %% [markdown]
# A PNG file begins with a fixed signature; bytes 16 to 23 are its width and height, the most
# significant byte first (PNG specification, section 11.2.1).

# %%
file = io.BytesIO()
figure.savefig(file, format="png")
print(file.getvalue()[:8], struct.unpack(">II", file.getvalue()[16:24]))

# %% [markdown]
# ## The check
#
# A picture of two halves in colours that are whole numbers of 255ths: the sum of each colour in
# each half is pixels times colour, and the PNG tells its size. The edge lies between two pixels, so
# nothing is blended.

# %%
print(WIDTH, "by", HEIGHT, "pixels")
names = [f"{side} {colour}" for side in ("left", "right") for colour in ("red", "green", "blue")]
verdict(CHECK, [*names, "width", "height"])

# %% [markdown]
# ## Try it yourself
#
# 1. Draw the edge above with `antialiased=False`. Which side gets the pixel in the middle?
# 2. Write the same figure as SVG. Which of the two files grows with the number of pixels?
