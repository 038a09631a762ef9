"""`plot`: a plan as a picture that can be shown in a talk."""

from __future__ import annotations

import io
import logging
import os
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from qrobot._extras import is_installed, load
from qrobot._extras import missing as missing_extra
from qrobot._files import StrPath, path_text, write_bytes_atomic, write_text_atomic
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Instance
from qrobot.report.animation import animation_page
from qrobot.report.fonts import families, font_notes
from qrobot.report.palette import INK
from qrobot.report.scene import scene_of

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["check_picture_path", "draw", "plot", "save", "style"]

DOTS_PER_INCH = 160


def plot(
    answer: Result | Plan | StrPath, path: StrPath, instance: Instance | StrPath | None = None
) -> None:
    """Draw a plan and write it as SVG or PNG, or as an animated page, as the file's suffix says.

    More than 12 trips are drawn on a small map each, too. Names are drawn in fonts of this machine
    that have their characters. A page (``.html``) shows the robots moving along their ways.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    path
        Where to write; never leaves a half-written file. The same plan gives the same file.
    instance
        The question; needed for a plan alone.

    Warns
    -----
    UserWarning
        What a person should know of the picture: characters that no font here has.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed; a page does not need it.
    InputError
        When the suffix is another one, the file cannot be written, or plan and instance do
        not belong together.
    """
    for note in draw(answer, path, instance):
        warnings.warn(note, stacklevel=2)


def draw(
    answer: Result | Plan | StrPath, path: StrPath, instance: Instance | StrPath | None = None
) -> tuple[str, ...]:
    """Do what `plot` does, and return what a person should know of the picture, a sentence each."""
    kind = check_picture_path(path, animated=True)
    scene = scene_of(answer, instance)
    if kind == "html":
        write_text_atomic(path, animation_page(scene))
        return ()
    texts = scene.texts()
    with style(texts) as missing:
        from qrobot.report.draw_aisles import draw_aisles
        from qrobot.report.draw_floor import draw_floor

        aisles = isinstance(scene.instance.warehouse, AisleWarehouse)
        save(draw_aisles(scene) if aisles else draw_floor(scene), path)
        # In an SVG text stays text, and who looks at it has fonts of their own.
        return tuple(font_notes(missing, texts)) if kind == "png" else ()


def check_picture_path(path: str | os.PathLike[str], *, animated: bool = False) -> str:
    """Return the kind of picture that a path asks for: ``svg`` or ``png``.

    Parameters
    ----------
    path
        Where it is to be written.
    animated
        Whether an animated page, ``html``, will do as well.

    Raises
    ------
    InputError
        When it is neither.
    MissingExtraError
        When matplotlib is not installed; found out without importing it.
    """
    kind = Path(path_text(path)).suffix.lower().lstrip(".")
    if kind == "html" and animated:
        return kind
    if not is_installed("matplotlib"):
        raise missing_extra("drawing pictures", "matplotlib")
    if kind not in {"svg", "png"}:
        raise InputError(
            f"{os.fspath(path)!r} does not say the kind of picture",
            advice="end it with .svg or .png" + (", or .html for a moving one" if animated else ""),
        )
    return kind


@contextmanager
def style(texts: Iterable[str] = ()) -> Iterator[str]:
    """Draw with settings of our own, whatever the user's matplotlib is set to.

    Matplotlib's warnings and log are not shown: the notes of `draw` say what a person should know.

    Parameters
    ----------
    texts
        Names and titles: fonts that have their characters are chosen.

    Yields
    ------
    str
        The characters that no font here has.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.CRITICAL)  # also of the import: a home that cannot be written
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            matplotlib = load("matplotlib", "drawing pictures")
            with matplotlib.rc_context():
                matplotlib.rcdefaults()
                fonts, missing = families(texts)
                matplotlib.rcParams.update(
                    {
                        "axes.labelcolor": INK,
                        "font.family": fonts,
                        "path.simplify": False,
                        "svg.fonttype": "none",  # text stays text: small files, can be searched
                        "svg.hashsalt": "qrobot",  # else every file has random ids
                        "text.color": INK,
                        "text.parse_math": False,  # a name with two dollar signs is a name
                    }
                )
                yield missing
    finally:
        log.setLevel(level)


def save(figure: Any, path: str | os.PathLike[str]) -> None:
    """Write a figure as SVG or PNG, without dates or versions in it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    kind = check_picture_path(path)
    data = io.BytesIO()
    if kind == "svg":
        metadata: dict[str, Any] = {"Date": None, "Creator": None}
        FigureCanvasSVG(figure).print_svg(data, metadata=metadata)
    else:
        FigureCanvasAgg(figure)
        figure.savefig(data, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    write_bytes_atomic(path, data.getvalue())
