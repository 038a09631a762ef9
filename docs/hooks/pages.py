"""Pages of the site whose source is not in docs/: the notebooks, and files of the repository.

mkdocs calls `on_files`. Notebooks are executed here unless QROBOT_DOCS_EXECUTE=false; where a
package is not installed, the rest of a notebook is shown without outputs.
"""

from __future__ import annotations

import ast
import html
import importlib.util
import posixpath
import re
import runpy
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import jupytext
from jupyter_client.manager import AsyncKernelManager
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

ROOT = Path(__file__).resolve().parents[2]

PAGES = {
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "CHANGELOG.md": "changelog.md",
    "healthchecks/README.md": "notebooks/index.md",
}
"""Markdown files of the repository, and the pages that they become."""

NOTEBOOKS = {"examples/tutorial.py": "tutorial.md"} | {
    f"healthchecks/{path.name}": f"notebooks/{path.stem}.md"
    for path in sorted((ROOT / "healthchecks").glob("check_*.py"))
}
"""Notebooks as scripts, and the pages that they become."""

shown = runpy.run_path(str(ROOT / "examples/run_tutorial.py"))["shown"]
"""Gives what a page can hold of an output, as HTML."""

ABSENT = {"ImportError", "MissingExtraError", "ModuleNotFoundError"}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    execute = bool(config.extra.get("execute", True))
    with ThreadPoolExecutor(2) as pool:
        pages = dict(
            zip(
                NOTEBOOKS.values(),
                pool.map(lambda source: page_of(ROOT / source, execute=execute), NOTEBOOKS),
                strict=True,
            )
        )
    for source, page in PAGES.items():
        pages[page] = (ROOT / source).read_text()
    sources = {page: source for source, page in (PAGES | NOTEBOOKS).items()}
    for page, text in pages.items():
        content = linked(text, sources[page], page)
        files.append(File.generated(config, page, content=content))
    return files


def linked(text: str, source: str, page: str) -> str:
    """Return a text whose links to files of the repository lead to pages of the site."""

    def on_the_site(target: str) -> str:
        target, hash_sign, anchor = target.partition("#")
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        path = (PAGES | NOTEBOOKS).get(path, path.removeprefix("docs/"))
        return posixpath.relpath(path, posixpath.dirname(page) or ".") + hash_sign + anchor

    text = re.sub(r"\]\((?!\w+:|#)([^)\s]+)\)", lambda m: f"]({on_the_site(m[1])})", text)
    text = re.sub(r"`(check_\w+)`", r"[`\1`](\1.md)", text) if page.endswith("index.md") else text
    return re.sub(
        r"`docs/([\w/-]+\.md)`",
        lambda m: f"[{m[1]}]({posixpath.relpath(m[1], posixpath.dirname(page) or '.')})",
        text,
    )


def page_of(path: Path, *, execute: bool) -> str:
    """Return a notebook as Markdown, with what its cells gave."""
    notebook = jupytext.read(path)
    absent = missing_package(path.read_text()) if execute else ""
    if execute and not absent:
        absent = run(notebook)
    parts: list[str] = [_note(path, absent)]
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
        elif cell.cell_type == "code":
            parts.append(f"````python\n{cell.source}\n````")
            parts += [_block(part) for output in cell.outputs for part in shown(output)]
    parts[:2] = reversed(parts[:2])  # the title is in the first cell
    return "\n\n".join(parts) + "\n"


def _note(path: Path, absent: str) -> str:
    note = f"A notebook; its source is <code>{path.relative_to(ROOT)}</code>."
    if path.parent.name == "healthchecks":
        note += ' <a href="../">All notebooks</a> of the health checks.'
    if absent:
        note += f" <code>{html.escape(absent)}</code> was not installed where this page was built:"
        note += " outputs that need it are left out."
    return f'<p class="notebook-note">{note}</p>'


def missing_package(source: str) -> str:
    """Return the first package that a script imports and that is not installed."""
    for node in ast.walk(ast.parse(source)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        for name in names:
            top = name.partition(".")[0]
            if importlib.util.find_spec(top) is None:
                return top
    return ""


def run(notebook: Any) -> str:
    """Execute a notebook; where a package is missing, end there and return its name."""
    with tempfile.TemporaryDirectory() as folder:  # the kernel is talked with by files in it
        kernel = AsyncKernelManager(transport="ipc", ip=f"{folder}/kernel")
        client = NotebookClient(
            notebook, kernel, timeout=None, resources={"metadata": {"path": str(ROOT)}}
        )
        return _executed(client)


def _executed(client: NotebookClient) -> str:
    try:
        client.execute(stderr=subprocess.DEVNULL)  # its log; what fails is raised
    except CellExecutionError as error:
        if error.ename not in ABSENT:
            raise
        for cell in client.nb.cells:
            if any(output.output_type == "error" for output in cell.get("outputs", ())):
                cell.outputs = []
        found = re.search(r"qrobot\[(\w+)\]|No module named '(\w+)", error.evalue)
        return (found[1] or found[2]) if found else error.evalue
    return ""


def _block(part: str) -> str:
    """Return a piece of HTML as one that Markdown leaves alone."""
    return (
        part
        if part.startswith("<pre")
        else f"<div class='output'>{part.replace(chr(10), ' ')}</div>"
    )
