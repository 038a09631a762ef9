"""Run the tutorial as a notebook: ``python examples/run_tutorial.py build/tutorial.ipynb``.

Beside the notebook goes a page of the same name, ``build/tutorial.html``: whole in one file, with
its formulas as MathML and its pictures inside, so that it can be read where there is no network.
"""

from __future__ import annotations

import html
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jupytext
import markdown
import nbformat
from nbclient import NotebookClient
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

EXAMPLES = Path(__file__).resolve().parent

EXTENSIONS = ["tables", "fenced_code", "l2m4m:LaTeX2MathMLExtension"]

PAGE = """<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }}
pre {{ overflow-x: auto; padding: .6rem .8rem; font-size: 14px; line-height: 1.35 }}
.highlight {{ background: #f6f8fa; border-left: 3px solid #4051b5 }}
.output {{ border-left: 3px solid #ccc }}
.error {{ border-left: 3px solid #c00 }}
img {{ max-width: 100% }}
table {{ border-collapse: collapse }} td, th {{ border: 1px solid #ccc; padding: .2rem .6rem }}
{style}
</style>
<body>
{body}
</body>
</html>
"""


def main(target: Path) -> None:
    """Execute the cells in the project's folder and write the notebook and its page."""
    notebook = jupytext.read(EXAMPLES / "tutorial.py")
    client = NotebookClient(
        notebook, timeout=None, resources={"metadata": {"path": str(EXAMPLES.parent)}}
    )
    try:
        client.execute()
    finally:
        target.parent.mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, target)
        page = target.with_suffix(".html")
        page.write_text(page_of(notebook, target.stem), encoding="utf-8")
    print(f"The notebook: {target}")
    print(f"The page:     {page}")


def page_of(notebook: Any, title: str) -> str:
    """Return a notebook as one page that asks the network for nothing."""
    formatter = HtmlFormatter()
    parts: list[str] = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(markdown.markdown(cell.source, extensions=EXTENSIONS))
        elif cell.cell_type == "code":
            parts.append(highlight(cell.source, PythonLexer(), formatter))
            parts += [part for output in cell.outputs for part in shown(output)]
    return PAGE.format(
        title=html.escape(title),
        style=formatter.get_style_defs(".highlight"),
        body="\n".join(parts),
    )


def shown(output: Any) -> Iterator[str]:
    """Give the richest form of an output that a page can hold."""
    if output.output_type == "stream":
        yield f'<pre class="output">{html.escape(output.text)}</pre>'
    elif output.output_type == "error":
        told = f"{output.ename}: {output.evalue}"
        yield f'<pre class="error">{html.escape(told)}</pre>'
    elif "image/png" in output.data:
        yield f'<img alt="" src="data:image/png;base64,{output.data["image/png"].strip()}">'
    elif "text/html" in output.data:
        yield output.data["text/html"]
    else:
        yield f'<pre class="output">{html.escape(output.data.get("text/plain", ""))}</pre>'


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/tutorial.ipynb"))
