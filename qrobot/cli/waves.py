"""``qrobot waves``: more orders than one plan holds, cut into waves that are planned in turn."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from qrobot.cli.options import (
    FILE,
    Question,
    ReadingCommand,
    Setting,
    objective,
    reading_options,
    settings_of,
)
from qrobot.cli.streams import say, say_json

if TYPE_CHECKING:
    from qrobot.planning.waves import Wave

__all__ = ["command"]


@click.command("waves", cls=ReadingCommand)
@click.argument("instance", type=FILE)
@click.option(
    "--output",
    "-o",
    "folder",
    required=True,
    type=FILE,
    help="Folder for an instance and a plan a wave, and waves.json.",
)
@click.option(
    "--by",
    default="size",
    show_default=True,
    help="How orders are put together: size (neighbours), due (what is due first) or zone.",
)
@click.option(
    "--size", type=int, default=2500, show_default=True, help="Most stops of a wave, up to 2500."
)
@click.option(
    "--zones",
    default="blocks",
    show_default=True,
    help="Zones of --by zone: blocks, or ranges of aisles such as 0-4,5-9.",
)
@click.option(
    "--picklists",
    type=click.Choice(["csv", "html", "json"]),
    help="Also write the pick lists of each wave in this format.",
)
@click.option("--resume", is_flag=True, help="Keep the finished waves of the folder.")
@click.option("--compare", is_flag=True, help="Also plan everything at once: the price of cutting.")
@click.option("--pairs", is_flag=True, help="Also plan neighbouring waves together, two by two.")
@click.option(
    "--backend",
    "-b",
    default="auto",
    show_default=True,
    help="Who plans; `qrobot backends` lists them.",
)
@click.option(
    "--deadline", "-t", type=float, help="Seconds for all waves.  [default: 10 for each wave]"
)
@click.option("--max-work", type=int, help="Limit of work units of each wave.")
@objective
@click.option("--routing", default="exact", show_default=True, help="As of solve.")
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of every random choice.")
@reading_options
@click.option(
    "--option",
    "-O",
    "settings",
    multiple=True,
    type=Setting(),
    help="Sampler: any of its options, such as num_reads=50. Repeatable.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, nothing else.")
@click.option("--quiet", "-q", is_flag=True, help="Only warnings and errors.")
def command(
    question: Question,
    folder: str,
    picklists: str | None,
    settings: tuple[tuple[str, Any], ...],
    as_json: bool,
    quiet: bool,
    **asked: Any,
) -> None:
    """Cut a pool of orders into waves, and plan one wave after the other.

    INSTANCE is a file of a known format: {formats}. JSON and CSV may hold any number of orders.
    Every wave has at most --size stops and fits into the robots' trips. Ctrl-C keeps the waves that
    are planned; --resume goes on with the others.

    \b
    Examples:
      qrobot waves examples/small-warehouse.json -o waves --size 8
      qrobot waves orders.csv --layout layout.json -o waves -t 300 --picklists html
      qrobot waves orders.csv -o waves --by due --resume
      qrobot waves examples/small-warehouse.json -o waves --size 8 --compare --json
    """
    # OpenBLAS reads this when numpy is imported; with more threads it spins on small matrices.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from qrobot.backends.registry import require

    require(asked["backend"])
    from qrobot.cli.progress import progress_line
    from qrobot.cli.signals import stop_on_signals
    from qrobot.planning.waves import plan_waves
    from qrobot.problem.formats import read

    options = settings_of({}, settings)

    def finished(wave: Wave) -> None:
        if picklists is not None:
            _write_lists(wave, folder, picklists)

    with stop_on_signals() as stop, progress_line(quiet or as_json) as line:
        waves = plan_waves(
            read(question.path, pool=True, **question.options),
            folder=folder,
            stop=stop,
            on_progress=line,
            on_wave=finished,
            **asked,
            **options,
        )
    if as_json:
        say_json(waves.to_dict())
    elif not quiet:
        say(waves.to_text(), end="")
        say(f"written: {os.path.join(folder, 'waves.json')}")
    if not waves.is_complete:
        raise click.Abort


def _write_lists(wave: Wave, folder: str, form: str) -> None:
    """Write the pick lists of a wave beside its plan."""
    from qrobot._files import write_text_atomic
    from qrobot.report import pick_lists, picklist_page

    lists = pick_lists(wave.plan, wave.instance)
    make: dict[str, Callable[[], str]] = {
        "csv": lists.to_csv,
        "json": lists.to_json,
        "html": lambda: picklist_page(lists, "a4"),
    }
    path = os.path.join(folder, f"wave-{wave.number:03d}.picks.{form}")
    write_text_atomic(path, make[form]())
