# %% [markdown]
# # jupytext: notebooks as plain Python
#
# This notebook is a Python file. `# %%` begins a cell of code, `# %% [markdown]` one of text.
# jupytext turns it into an `.ipynb` and back. So it can be read in an editor, compared line by
# line, checked by a linter, and run by plain `python`.

# %%
import json

import jupytext

from qrobot.health.checks.jupytext import CHECK, SCRIPT
from qrobot.health.lesson import table, verdict

print(SCRIPT)

# %%
notebook = jupytext.reads(SCRIPT, fmt="py:percent")
table(
    ["cell", "kind", "tags", "first line"],
    [
        (k, cell.cell_type, str(cell.metadata.get("tags", [])), cell.source.splitlines()[0])
        for k, cell in enumerate(notebook.cells, 1)
    ],
)

# %% [markdown]
# ## What is saved
#
# The same cells as JSON take many more characters, before there is any output. Outputs are never
# in the Python file: they are made again by running it. That is the point of this folder: a picture
# that was made last year on another machine proves nothing about this one.

# %%
as_json = json.dumps(notebook, indent=1)
print(len(SCRIPT), "characters as a script,", len(as_json), "as a notebook")

# %% [markdown]
# ## The check
#
# The script above has three cells, two of them code, with three lines of code and one tag; and on
# the way back no line may be lost or stand elsewhere. All of this can be counted by eye.

# %%
verdict(CHECK, ["cells", "of them code", "lines of code", "tags", "lines lost"])

# %% [markdown]
# ## Try it yourself
#
# 1. Convert this notebook with `jupytext --to ipynb healthchecks/check_jupytext.py`.
# 2. `jupytext.writes(notebook, fmt="md")` gives another face of it. Which one would you print?
