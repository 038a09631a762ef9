"""jupytext: a script to a notebook and back."""

from qrobot.health.check import Check

SCRIPT = """\
# %% [markdown]
# A title

# %%
x = 6
y = 7

# %% tags=["last"]
print(x * y)
"""


def answer() -> list[float]:
    """Return the cells, those that are code, lines of code, tags, and lines lost or moved."""
    import jupytext

    notebook = jupytext.reads(SCRIPT, fmt="py:percent")
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    back = jupytext.writes(notebook, fmt="py:percent")
    lines = iter(back.splitlines())
    kept = sum(line in lines for line in SCRIPT.splitlines())  # each behind the one before
    return [
        len(notebook.cells),
        len(code),
        sum(len(cell.source.splitlines()) for cell in code),
        sum(len(cell.metadata.get("tags", ())) for cell in notebook.cells),
        len(SCRIPT.splitlines()) - kept,
    ]


def expected() -> list[float]:
    """Return what the script shows to the eye."""
    return [3, 2, 3, 1, 0]


CHECK = Check(
    __name__,
    title="a script to a notebook and back",
    group="lab",
    imports=("jupytext",),
    source="counting",
    extra="lab",
)
